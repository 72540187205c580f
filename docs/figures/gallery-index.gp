# The surface of Greenwood and Williamson at a plasticity index of 0.92: summits that touch.
height = 420
load 'style.gp'
outputs = '../../data/examples/effects/'
set xlabel 'Load per summit (N)'
set ylabel 'Summits in contact, of 400'
set xrange [0:*]
set yrange [0:400]
set key off
plot outputs . 'index_092.curve.csv' using (column('load') / 400):'contacts' with linespoints \
  linetype 3 pointtype 7 pointsize 0.6
