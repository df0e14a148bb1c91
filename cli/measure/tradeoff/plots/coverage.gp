# Share of stated intervals that hold, minus the nominal share. Bars: the standard error of independent runs.
if (ARGC > 0) cd ARG1
plot = 'coverage'
load 'style.gp'
table = '../intervals.csv'
set xtics auto
set ytics auto
set xlabel 'intervals that should hold (%)'
set ylabel 'intervals that hold minus those that should (percentage points)'
set xrange [45:102]
set yrange [*<-5:5<*]
families = '"independent" "sobol" "independent adaptive" "sobol adaptive" "sobol denoised" "sobol adaptive denoised" "all"'
of(i, x) = strcol('intervals') eq word(families, i) ? x : NaN
pixels(i, x) = column('pixel_runs') > 0 ? of(i, x) : NaN
# Shows pictures of a single kind only if its pixels have no intervals.
pictures(i, x) = column('runs') >= 16 && (i == 7 || column('pixel_runs') == 0) ? of(i, x) : NaN
excess(what) = 100 * (column(what) - column('nominal'))
scatter(x) = 100 * sqrt(x * (1 - x) / column('runs'))
array with_pixels[7]
array with_pictures[7]
do for [i = 1:7] {
  stats table using (pixels(i, 1) == 1 ? 1 : 0) name 'n' nooutput
  with_pixels[i] = int(n_sum)
  stats table using (pictures(i, 1) == 1 ? 1 : 0) name 'n' nooutput
  with_pictures[i] = int(n_sum)
}
plot 0 lc rgb '#888888' dt 2 title 'exact', \
     for [i = 1:7] table using (pixels(i, 100 * column('nominal'))):(excess('pixels')) \
       with linespoints pt marker(i, full) ps 1 lc rgb colour(i) title (with_pixels[i] > 0 ? 'pixels, '.word(families, i) : ''), \
     for [i = 1:7] table using (pictures(i, 100 * column('nominal') + 0.4)):(excess('pictures')):(scatter(column('nominal'))) \
       with yerrorbars pt marker(i, hollow) ps 1 lc rgb colour(i) title (with_pictures[i] > 0 ? "pictures' RMSE, ".word(families, i) : '')
load 'export.gp'
