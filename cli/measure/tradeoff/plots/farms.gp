# The modelled Pareto fronts of farms.
if (ARGC > 0) cd ARG1
plot = 'farms'
load 'style.gp'
table = '../farms.csv'
set logscale xy
set xlabel farm_axis
set ylabel error_axis
on_front(x) = column('on_front') == 1 ? x : NaN
stats table using (on_front(column('modelled_seconds'))):(on_front(column('rmse'))) name 'all' nooutput
set xrange [low(all_min_x, all_max_x, 0.05):high(all_min_x, all_max_x, 0.3)]
set yrange [low(all_min_y, all_max_y, 0.08):high(all_min_y, all_max_y, 0.08)]
height = log10(all_max_y / all_min_y * 1.01) / 36
of(workers, x) = column('workers') == workers ? on_front(x) : NaN
workers(i) = int(word('1 4 16 64', i))
plot for [i = 1:4] table using (of(workers(i), column('modelled_seconds'))):'rmse' smooth unique \
       with linespoints pt marker(i, full) ps 1 lc rgb colour(i) title sprintf('%d worker%s', workers(i), i == 1 ? '' : 's'), \
     table using (of(1, column('modelled_seconds'))):'rmse':(name_once(of(1, 1), column('rmse'), strcol('name'))) \
       with labels left offset 1.2,0.5 notitle
load 'export.gp'
