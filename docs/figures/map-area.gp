# Contact area over pressure of random height maps, against pressure: pixels, summits, theories.
height = 420
load 'style.gp'
if (!exists('table')) table = '../../reference_output/bench/map_area.csv'
set xlabel 'Nominal pressure / (contact modulus × rms slope)'
set ylabel 'Area fraction / (pressure / (modulus × slope))' offset 1.5
set logscale x
set xrange [0.0009:0.35]
set yrange [1.2:2.7]
unset key
set label 'Bush, Gibson and Thomas, small pressures' at 0.0011, 2.56 textcolor rgb '#666666'
set label 'Persson' at 0.0011, 1.55 textcolor rgb '#222222'
set label 'summits, interacting' at 0.012, 2.03 textcolor rgb '#BB5566'
set label 'pixels, periodic' at 0.07, 1.86 textcolor rgb '#004488'
set label 'pixels, free edge' at 0.0135, 1.735 textcolor rgb '#4488BB'
set label 'summits, isolated' at 0.0035, 1.50 textcolor rgb '#AA7711'
names = 'pixels_periodic pixels_free summits_coupled summits_off'
colour(i) = word('#004488 #66AADD #BB5566 #DDAA33', i)
of(i) = strcol('method') eq word(names, i) ? column('area_fraction') / column('pressure') : NaN
set datafile missing NaN
set datafile commentschars '#'
set samples 500
plot sqrt(2 * pi) with lines linecolor rgb '#888888' dashtype 2 linewidth 2, \
  erf(sqrt(2) * x) / x with lines linecolor rgb '#222222' dashtype 3 linewidth 2, \
  for [i = 1:4] table using 'pressure':(of(i)) with linespoints linecolor rgb colour(i) \
    linewidth 2 pointtype 7 pointsize 0.6
