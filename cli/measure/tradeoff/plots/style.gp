# Settings of all plots. front.gp draws front.svg, .pdf and .png: `gnuplot front.gp` in this directory.
set terminal svg noenhanced size 900,600 font 'DejaVu Sans,12' background rgb 'white'
set output plot.'.svg'
load 'values.gp'
set datafile separator ','
set datafile columnheaders
set datafile missing NaN
table = '../tradeoff.csv'
if (!exists('bottom')) bottom = 0.27
set lmargin at screen 0.09
set rmargin at screen 0.98
set tmargin at screen 0.97
set bmargin at screen bottom
set label caption at screen 0.5, screen 0.02 center
set key at screen 0.5, screen bottom - 0.087 center top horizontal maxcols 3 Left reverse samplen 2
set grid lt 1 lw 0.5 lc rgb '#dddddd'

# Okabe and Ito's colours, which people with any colour vision can distinguish. Markers: full and hollow.
colours = '#0072B2 #D55E00 #009E73 #CC79A7 #E69F00 #56B4E9 #000000'
full = '7 5 9 11 13 15 3'
hollow = '6 4 8 10 12 14 2'
families = '"independent" "sobol" "independent adaptive" "sobol adaptive" "sobol denoised" "sobol adaptive denoised" "other"'
colour(i) = word(colours, i)
marker(i, list) = int(word(list, i))
shown(i) = word(families, i).(i == 7 ? ' depth, precision or search' : '')

has_error(x) = column('rmse') > 0 ? x : NaN
of_family(i, x) = column('rmse') > 0 && strcol('family') eq word(families, i) ? x : NaN

# Space around the points of a logarithmic axis, as a share of their extent.
low(least, most, room) = least * (least / (most * 1.01)) ** room
high(least, most, room) = most * ((most * 1.01) / least) ** room
set xtics () nomirror
set ytics () nomirror
do for [power = -9:6] {
  do for [digit in '1 2 5'] {
    tic = digit * 10.0 ** power
    set xtics add (sprintf('%g', tic) tic)
    set ytics add (sprintf('%g', tic) tic)
  }
}
error_axis = 'RMSE (linear radiance)'

# The name of a point, or nothing if another name is at about the same height. `height`: logarithm of a line's height.
names = ''
at(y) = int(floor(log10(y) / height))
is_free(y) = strstrt(names, sprintf('|%d|', at(y))) == 0
taken(y) = sprintf('|%d||%d||%d|', at(y) - 1, at(y), at(y) + 1)
name_once(x, y, text) = x == x && is_free(y) ? (names = names.taken(y), text) : ''
