# Figure 12 of the thesis: contact area against load.
height = 520
load 'style.gp'
load 'curves.gp'
set logscale xy
set xlabel 'Total load (N)'
set ylabel 'Contact area (cm^2)'
set xrange [1:2000]
set yrange [0.0005:0.2]
set format y '%g'
set ytics add (0.0005, 0.002, 0.005, 0.02, 0.05, 0.2)
set key top left reverse Left
plot for [k = 1:3] curve(k) using 'load':'area' with lines linetype k title title_of(k), \
  for [k = 1:3] printed(k) using 1:4 with points linetype 4 notitle, \
  NaN with points linetype 4 title 'printed in the thesis'
