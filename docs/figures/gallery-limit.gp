# One pair of summits past its limit: contact area with flow and by Hertz.
height = 420
load 'style.gp'
outputs = '../../data/examples/effects/'
set xlabel 'Load (N)'
set ylabel 'Contact area (cm^2)'
set xrange [0:2950]
set yrange [0:*]
set key left top Left reverse
plot outputs . 'beyond_limit.curve.csv' using 'load':'area' with linespoints linetype 3 \
    pointtype 7 pointsize 0.5 title 'auto: plastic from 1.5 times the limit load on', \
  outputs . 'beyond_limit_hertz.curve.csv' using 'load':'area' with linespoints linetype 1 \
    pointtype 7 pointsize 0.5 title 'Hertz'
