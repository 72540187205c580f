# Figure 11 of the thesis: decrease of approach against load.
height = 520
load 'style.gp'
load 'curves.gp'
set logscale xy
set xlabel 'Total load (N)'
set ylabel 'Compression (cm)'
set xrange [1:2000]
set yrange [0.0002:0.02]
set format y '%g'
set ytics add (0.0002, 0.0005, 0.002, 0.005, 0.02)
set key top left reverse Left
plot for [k = 1:3] curve(k) using 'load':'compression' with lines linetype k title title_of(k), \
  for [k = 1:3] printed(k) using 1:3 with points linetype 4 notitle, \
  NaN with points linetype 4 title 'printed in the thesis'
