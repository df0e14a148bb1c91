// What a user may do with a job.

const actionsOf = {  // the actions that each state permits
  queued: ['pause', 'cancel'], running: ['pause', 'cancel'], finishing: ['cancel'], paused: ['resume', 'cancel'],
  done: ['delete'], failed: ['requeue', 'delete'], cancelled: ['requeue', 'delete']};

/** Returns whether the user may control the job. A missing role or user means that the server decides. */
export const mayControl = (job, server) => server?.role !== 'client' || !server.user || server.user === job.user;

/** Returns whether `word` (pause, resume, cancel, requeue, delete, priority) makes sense for the state of a job. */
export const permits = (job, word) => word === 'priority' ? ['queued', 'running', 'paused'].includes(job.state) :
  actionsOf[job.state]?.includes(word) ?? false;
