# Time and error of all settings, and their Pareto front.
if (ARGC > 0) cd ARG1
plot = 'front'
load 'style.gp'
set xlabel time_axis
set ylabel error_axis
stats table using (has_error(column('seconds'))):(has_error(column('rmse'))) name 'all' nooutput
height = log10(all_max_y / all_min_y * 1.01) / 36
on_front(x) = column('rmse') > 0 && column('on_front') == 1 ? x : NaN
wanted(knob) = column('rmse') > 0 && strcol('knob') eq knob
scene(x) = wanted('scene') ? x : NaN
also(x) = wanted('also') && column('on_front') == 0 ? x : NaN
array points[7]
do for [i = 1:7] {
  stats table using (of_family(i, 1) == 1 ? 1 : 0) name 'n' nooutput
  points[i] = int(n_sum)
}
set logscale xy
set xrange [low(all_min_x, all_max_x, 0.3):high(all_min_x, all_max_x, 0.1)]
set yrange [low(all_min_y, all_max_y, 0.1):high(all_min_y, all_max_y, 0.08)]
plot table using (on_front(column('seconds'))):'rmse' smooth unique with lines lw 1 lc rgb '#888888' title 'Pareto front', \
     for [i = 1:7] table using (column('on_front') == 0 ? of_family(i, column('seconds')) : NaN):'rmse':'seconds_q1':'seconds_q3' \
       with xerrorbars pt marker(i, hollow) ps 1 lc rgb colour(i) notitle, \
     for [i = 1:7] table using (column('on_front') == 1 ? of_family(i, column('seconds')) : NaN):'rmse':'seconds_q1':'seconds_q3' \
       with xerrorbars pt marker(i, full) ps 1 lc rgb colour(i) notitle, \
     for [i = 1:7] NaN with points pt marker(i, full) ps 1 lc rgb colour(i) title (points[i] > 0 ? shown(i) : ''), \
     NaN with points pt 6 ps 1 lc rgb '#888888' title 'hollow: dominated', \
     table using (scene(column('seconds'))):'rmse':(name_once(scene(1), column('rmse'), "the scene's own: ".strcol('name'))) \
       with labels right offset -1.2,-0.5 notitle, \
     table using (on_front(column('seconds'))):'rmse':(name_once(on_front(1), column('rmse'), strcol('name'))) \
       with labels right offset -1.2,-0.5 notitle, \
     table using (also(column('seconds'))):'rmse':(name_once(also(1), column('rmse'), strcol('name'))) \
       with labels right offset -1.2,0.5 notitle
load 'export.gp'
