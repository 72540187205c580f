# Separation and mean gap of a map with a free edge against the size of the scan.
height = 360
load 'style.gp'
table = '../../reference_output/bench/scan_size.csv'
set xlabel 'Side of the scan / roll-off wavelength'
set ylabel 'Length / rms height' offset -0.5
set logscale x 2
set xrange [0.9:17.5]
set yrange [-7.5:1.5]
set key at graph 0.05, 0.3 left top Left reverse
set datafile commentschars '#'
plot table using 'side':'mean_gap' with linespoints linecolor rgb '#004488' linewidth 2 \
    pointtype 7 title 'mean gap', \
  table using 'side':'separation' with linespoints linecolor rgb '#BB5566' linewidth 2 \
    pointtype 7 title 'separation of the reference planes'
