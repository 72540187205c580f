# Error of the totals against time for each position: all methods of `asperity accuracy`.
height = 560
load 'style.gp'
file = data . '/accuracy.csv'
arithmetics = 'ibm370 real32 real64 real128'
array colour[4] = [red, yellow, blue, 0x222222]
set linetype 5 linecolor rgb '#222222' linewidth 1 dashtype 2

# Microseconds a position: the sweep has 100.
microseconds = 1e4
has(text) = strstrt(strcol('method'), text) > 0
is(column, text) = strcol(column) eq text
error_of(wanted) = wanted && column('error_max') > 0 ? column('error_max') : NaN
time_of(wanted) = wanted ? microseconds * column('seconds') : NaN
# The option to type for a method with neighbours.
option(x) = has('isolated') ? 'off' : has('coupled') ? 'coupled' : \
  has('auto') ? 'auto, ' . strcol('method')[17:*] : 'boundary, ' . strcol('method')[20:*]
# Labels below their point, beside a neighbour's.
lower(below) = is('family', 'neighbours') && has('0.003') == below
program(a) = has('original program') && is('arithmetic', word(arithmetics, a))
single(a) = !has('original program') && is('overlap', 'stable') && \
  (is('family', 'arithmetic') || is('family', 'steps')) && is('arithmetic', word(arithmetics, a))

# The error of the reference, and what half a digit of the printed heights is worth.
stats "< awk -F, '$30 == 1 { print $24 }' " . file nooutput name 'reference'
stats "< awk -F, '$1 == \"input\" { print $13 }' " . file nooutput name 'input'

set logscale xy
set xlabel 'Run time for each position (µs)'
set ylabel 'Largest relative error of the load over all positions'
set xrange [1.5:50000]
set yrange [1e-5:10]
set format x '%g'
set format y '10^{%T}'
set ytics 1e-5, 10, 10 nomirror
unset mxtics
unset mytics
set rmargin at screen 0.768
set key at screen 0.785, 0.955 left top reverse Left samplen 1.2 spacing 1.25 font ',13'
set arrow 1 from 1.5, input_max to 50000, input_max nohead linecolor rgb '#999999' dashtype 3
set label 1 'half a digit of the heights' at 46000, 1.45 * input_max \
  right textcolor rgb '#666666' font ',11'
set arrow 2 from 1.5, reference_max to 50000, reference_max nohead linecolor rgb '#999999' dashtype 3
set label 2 'estimated error of the reference' at 46000, 0.7 * reference_max \
  right textcolor rgb '#666666' font ',11'

plot "< awk -F, 'NR == 1 || ($28 == 1 && $9 > 0)' " . file \
    using (microseconds * column('seconds')):(column('error_max')) \
    smooth unique with lines linetype 5 title 'Pareto front', \
  for [a = 1:4] file using (time_of(program(a))):(error_of(program(a))) \
    with points pointtype 5 pointsize 0.65 linecolor rgb colour[a] notitle, \
  for [a = 3:3] file using (time_of(single(a))):(error_of(single(a))) \
    with points pointtype 9 pointsize 0.75 linecolor rgb colour[a] notitle, \
  file using (time_of(is('family', 'neighbours'))):(error_of(is('family', 'neighbours'))) \
    with points pointtype 7 pointsize 0.75 linecolor rgb blue notitle, \
  file using (time_of(is('family', 'neighbours'))):(error_of(is('family', 'neighbours'))): \
    (lower(1) ? option(0) : '') with labels left offset 0.8, -0.6 \
    font ',11' textcolor rgb '#333333' notitle, \
  file using (time_of(is('family', 'neighbours'))):(error_of(is('family', 'neighbours'))): \
    (lower(0) ? option(0) : '') with labels left offset 0.8, 0.7 \
    font ',11' textcolor rgb '#333333' notitle, \
  NaN with lines linecolor rgb 'white' title ' ', \
  NaN with points pointtype 7 pointsize 0.75 linecolor rgb blue title 'interaction', \
  NaN with points pointtype 9 pointsize 0.75 linecolor rgb blue title 'steps, isolated', \
  NaN with points pointtype 5 pointsize 0.65 linecolor rgb '#666666' title 'original program:', \
  for [a = 1:4] NaN with lines linewidth 6 linecolor rgb colour[a] title word(arithmetics, a)
