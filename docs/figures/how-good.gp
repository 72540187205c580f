# Summits and theories against the pixels of fifteen maps: medians of the error of separation and of
# the ratio of areas, against the area fraction.
height = 460
load 'style.gp'
all = '../../reference_output/bench/maps.csv'
set xlabel 'Area fraction (%)'
set logscale x
set xrange [0.2:30]
set xtics ('0.3' 0.3, '1' 1, '3' 3, '10' 10, '20' 20)
names = 'contact plain alone half greenwood_williamson bush_gibson_thomas persson'
titles = "'summits, coupled' 'plain summits' 'isolated summits' 'half resolution' \
  'Greenwood, Williamson' 'Bush, Gibson, Thomas' 'Persson'"
colour(i) = word('#004488 #BB5566 #DDAA33 #222222 #888888 #888888 #888888', i)
dash(i) = i < 5 ? 1 : i - 3
of(i, value) = strcol('way') eq word(names, i) ? column(value) : NaN
set datafile missing NaN
set multiplot layout 1, 2
set lmargin 8
set ylabel 'Error of separation (rms heights)' offset 1.5
set logscale y
set yrange [0.01:10]
set key off
plot for [i = 1:7] all using (100 * of(i, 'share')):(of(i, 'error_median')) with linespoints \
  linecolor rgb colour(i) dashtype dash(i) linewidth 2 pointtype (i < 5 ? 7 : i + 1) pointsize 0.6
unset logscale y
set ylabel 'Area over that of the pixels' offset 1.5
set yrange [0.6:2]
set key at graph 0.98, 0.99 right top noreverse Right samplen 3 spacing 1.05
plot for [i = 1:7] all using (100 * of(i, 'share')):(of(i, 'area_median')) with linespoints \
  linecolor rgb colour(i) dashtype dash(i) linewidth 2 pointtype (i < 5 ? 7 : i + 1) pointsize 0.6 \
  title word(titles, i)
unset multiplot
