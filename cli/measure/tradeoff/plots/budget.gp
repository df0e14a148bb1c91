# The parts of the error of an 8-bit picture.
if (ARGC > 0) cd ARG1
plot = 'budget'
bottom = 0.45
load 'style.gp'
set key at screen 0.5, screen 0.1 center top horizontal maxcols 5
set style data histogram
set style histogram rowstacked
set boxwidth 0.8
set xtics rotate by 60 right
set xtics auto
set ytics auto
set yrange [0:*]
set ylabel "part of the PNG's measured MSE (%)"
share(part) = column('rmse_8bit') > 0 ? 100 * (column(part) / column('rmse_8bit')) ** 2 : NaN
plot table using (share('eps_mc')):xtic(stringcolumn('name')) fs solid lc rgb '#0072B2' title 'noise (stated)', \
     table using (share('eps_depth')) fs pattern 4 lc rgb '#D55E00' title 'depth', \
     table using (share('eps_precision')) fs pattern 5 lc rgb '#009E73' title 'precision', \
     table using (share('eps_quantisation')) fs pattern 2 lc rgb '#E69F00' title '8 bits', \
     100 with lines lw 2 lc rgb 'black' title 'measured'
load 'export.gp'
