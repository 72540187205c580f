# The models of the thesis in gelatine: load against separation.
height = 480
load 'style.gp'
outputs = '../../data/examples/effects/'
set xlabel 'Separation (cm), decreasing'
set ylabel 'Load (mN)'
set xrange [0.302:0.259]
set yrange [-12.5:7.5]
set key at graph 0.03, 0.97 left top reverse Left
set xzeroaxis linetype 1 linecolor rgb '#666666' linewidth 0.8
curve = outputs . 'gelatine.curve.csv'
part(k) = sprintf("< awk -F, 'NR > 1 && $2 > %d && $2 <= %d' %s", 100 * k, 100 * k + 101, curve)
plot part(0) using 3:($6 * 1000) with lines linetype 3 title 'loading', \
  part(1) using 3:($6 * 1000) with lines linetype 2 title 'unloading', \
  part(2) using 3:($6 * 1000) with points linecolor rgb '#222222' pointtype 6 pointsize 0.4 \
    title 'reloading'
