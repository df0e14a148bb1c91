# The same plot as a PDF for papers and as a PNG.
set terminal pdfcairo noenhanced size 9.375in,6.25in font 'DejaVu Sans,9' fontscale 0.75
set output plot.'.pdf'
names = ''
replot
set terminal pngcairo noenhanced size 900,600 font 'DejaVu Sans,9'
set output plot.'.png'
names = ''
replot
set output
