# Loading the models past the limit, and unloading: load against compression.
height = 480
load 'style.gp'
outputs = '../../data/examples/effects/'
set xlabel 'Compression (cm)'
set ylabel 'Load (kN)'
set xrange [0:0.052]
set yrange [0:12.6]
set key at graph 0.02, 0.98 left top reverse Left
# The first contact of this position is at its limit there.
limit = 1.372
set arrow 1 from 0, limit to 0.0295, limit nohead linecolor rgb '#999999' dashtype 3
set label 1 'first contact at its limit' at 0.03, limit textcolor rgb '#555555'
cycle = outputs . 'cycle.curve.csv'
# Steps 2 to 41 go up, 42 to 81 down, and so on.
part(k) = sprintf("< awk -F, 'NR > 1 && $2 > %d && $2 <= %d' %s", 40 * k, 40 * k + 41, cycle)
plot outputs . 'cycle_elastic.curve.csv' using 'compression':(column('load') / 1000) with lines \
    linecolor rgb '#999999' linewidth 1.5 dashtype 2 title 'elastic: loading and unloading', \
  for [k = 0:4:2] part(k) using 4:($6 / 1000) with lines linetype 3 \
    title (k == 0 ? 'plastic: loading' : ''), \
  for [k = 1:5:2] part(k) using 4:($6 / 1000) with lines linetype 2 \
    title (k == 1 ? 'unloading' : '')
