# Error against samples, with a power law for each way of sampling.
if (ARGC > 0) cd ARG1
plot = 'convergence'
load 'style.gp'
set xlabel 'samples per pixel'
set ylabel error_axis
in_family(x) = strcol('family') eq 'other' ? NaN : has_error(x)
stats table using (in_family(column('samples_per_pixel'))):(in_family(column('rmse'))) name 'all' nooutput
array slope[6]
array intercept[6]
array least[6]
array most[6]
array points[6]
do for [i = 1:6] {
  stats table using (of_family(i, 1) == 1 ? 1 : 0) name 'n' nooutput
  points[i] = int(n_sum)
  if (points[i] >= 2) {
    stats table using (of_family(i, log10(column('samples_per_pixel')))):(of_family(i, log10(column('rmse')))) name 'law' nooutput
    slope[i] = law_slope
    intercept[i] = law_intercept
    least[i] = 10 ** law_min_x
    most[i] = 10 ** law_max_x
  }
}
law(i, x) = points[i] >= 2 && x >= least[i] && x <= most[i] ? 10 ** (intercept[i] + slope[i] * log10(x)) : NaN
title(i) = points[i] == 0 ? '' : shown(i).(points[i] >= 2 ? sprintf(' (slope %.2f)', slope[i]) : '')
set logscale xy
set xrange [low(all_min_x, all_max_x, 0.05):high(all_min_x, all_max_x, 0.05)]
set yrange [low(all_min_y, all_max_y, 0.08):high(all_min_y, all_max_y, 0.08)]
plot for [i = 1:6] law(i, x) with lines lc rgb colour(i) notitle, \
     for [i = 1:6] table using (of_family(i, column('samples_per_pixel'))):'rmse':'rmse_sd' \
       with yerrorbars pt marker(i, full) ps 1 lc rgb colour(i) title title(i)
load 'export.gp'
