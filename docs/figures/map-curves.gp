# A map pressed by a flat: its summits and its samples. Contact area and separation against pressure.
height = 400
load 'style.gp'
summits = data . '/press.csv'
samples = data . '/press_samples.csv'
set xlabel 'Nominal pressure (MPa)'
set xrange [0:205]
set multiplot layout 1, 2
set ylabel 'Area fraction'
set yrange [0:0.13]
set key at graph 0.05, 0.95 left top reverse Left
plot samples using 'nominal_pressure':'area_fraction' with points linetype 4 pointsize 0.8 \
    title 'pixels', \
  summits using 'nominal_pressure':'area_fraction' with lines linetype 3 title 'summits'
set ylabel 'Separation (µm)' offset 1
set yrange [-0.15:0.35]
set key at graph 0.95, 0.95 right top noreverse Right
plot samples using 'nominal_pressure':'separation' with points linetype 4 pointsize 0.8 \
    title 'pixels', \
  summits using 'nominal_pressure':'separation' with lines linetype 3 title 'summits'
unset multiplot
