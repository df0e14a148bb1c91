// Notifications of the browser when jobs of this user have ended. The user switches them on.

import {notify} from './dom.js';

const place = 'parray-notices';
const mostAtOnce = 3;

/** Browsers offer notifications only to pages from this machine or with HTTPS. */
export const canNotify = () => 'Notification' in window && isSecureContext;
export const notices = () => canNotify() && localStorage.getItem(place) === 'on' && Notification.permission === 'granted';

/** Switches notifications on or off. The browser may ask the user first. Returns whether they are on now. */
export async function switchNotices(on) {
  localStorage.removeItem(place);
  if (!on) return false;
  if (await Notification.requestPermission() !== 'granted') {
    notify('The browser does not permit notifications of this page. Permit them in its settings.', 'error');
    return false;
  }
  localStorage.setItem(place, 'on');
  return true;
}

/** Notifies of ended jobs: not of frames, quick looks and jobs of other users. */
export function noticeEnded(jobs, user) {
  if (!notices()) return;
  const own = jobs.filter(job => job.frame === undefined && job.preview_of === undefined && (!user || job.user === user));
  for (const job of own.slice(0, mostAtOnce)) {
    const notice = new Notification(`${job.name || 'Job ' + job.id}: ${job.state}`, {body: job.reason || `Job ${job.id}`, icon: 'icon.svg', tag: `parray-${job.id}`});
    notice.addEventListener('click', () => {
      window.focus();
      location.hash = `#/jobs/${job.id}`;
      notice.close();
    });
  }
  if (own.length > mostAtOnce) new Notification(`${own.length - mostAtOnce} more jobs have ended`, {icon: 'icon.svg', tag: 'parray-more'});
}
