# Sections of the thesis' design: means and spread against their size, from
# `asperity study data/examples/study/thesis.spec`.
height = 640
load 'style.gp'
file = data . '/area_study.csv'
names = 'load area contacts'
array title[3] = ['load', 'contact area', 'contacts']
array shift[3] = [1.05, 1, 0.952]
is(name) = strcol('quantity') eq name ? 1 : NaN

set logscale x
set xrange [3.6:140]
set xtics (4.4, 8.8, 17.6, 28, 44, 70, 112)
set lmargin at screen 0.115
set rmargin at screen 0.97
set multiplot

# Above: means, in parts of the integral.
set tmargin at screen 0.95
set bmargin at screen 0.63
set format x ''
set ylabel "mean / integral"
set yrange [0.95:1.07]
set format y '%.2f'
set ytics 0.05
unset key
set label 1 'bars: standard error' at graph 0.02, 0.93 textcolor rgb '#666666' font ',12'
set arrow 1 from 3.6, 1 to 140, 1 nohead linecolor rgb '#222222' dashtype 2
plot for [i = 1:3] file using (shift[i] * column('size')): \
  (is(word(names, i)) * column('mean') / column('integral')): \
  (column('standard_error') / column('integral')) \
  with yerrorbars linetype i linewidth 1.6 pointtype 7 pointsize 0.6 notitle
unset label 1
unset arrow 1

# Below: spread of the sections, in percent of the integral.
set tmargin at screen 0.60
set bmargin at screen 0.105
set format x '%g'
set xlabel 'Side of a section (cm)'
set ylabel "standard deviation of a section\n(% of the integral)"
set logscale y
set yrange [3:300]
set format y '%g'
set ytics (3, 10, 30, 100, 300)
set key top right
set label 2 'thesis, upper plate' at 8.8, 3.6 left offset 0.6, 0 textcolor rgb '#666666' font ',12'
set arrow 2 from 8.8, 3 to 8.8, 300 nohead linecolor rgb '#999999' dashtype 3
guide(x) = 932. / x
plot for [i = 1:3] file using (column('size')): \
  (100 * is(word(names, i)) * column('deviation') / column('integral')) \
  with points linetype i pointtype 7 pointsize 0.6 title title[i], \
  guide(x) linecolor rgb '#222222' linewidth 1 dashtype 2 title '1/side'
unset multiplot
