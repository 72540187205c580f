# Error against time a position: arithmetics and steps of `asperity accuracy`.
height = 560
load 'style.gp'
file = data . '/accuracy.csv'
arithmetics = 'ibm370 real32 real64 real128'
methods = 'exact steps program'
method_names = "'exact events' 'marching' 'original program'"
array colour[4] = [red, yellow, blue, 0x222222]
array filled[3] = [7, 9, 5]
array open[3] = [6, 8, 4]
set linetype 5 linecolor rgb '#222222' linewidth 1 dashtype 2

# An error of zero has no place on a logarithmic axis.
floor_at = 1e-17
place(error) = error > floor_at ? error : floor_at
is(column, text) = strcol(column) eq text
# Microseconds a position: the sweep has 100.
microseconds = 1e4
worst(total) = place(column('pressure_max') > column(total) ? column('pressure_max') : column(total))
uses(m) = strstrt(strcol('method'), word(methods, m)) > 0

set logscale xy
set xlabel 'Run time for each position (µs)'
set ylabel 'Largest relative error of the totals over all positions'
set xrange [2:50000]
set yrange [1e-18:30]
set format x '%g'
set format y '10^{%T}'
set ytics 1e-15, 1000, 1 nomirror
unset mxtics
unset mytics
set ytics add ('0' floor_at)
set rmargin at screen 0.768
set key at screen 0.785, 0.955 left top reverse Left samplen 1.2 spacing 1.25 font ',13'
set arrow 1 from 2, floor_at to 50000, floor_at nohead linecolor rgb '#999999' dashtype 3
set label 1 'zero error, drawn at 10^{-17}' at 2.5, 4 * floor_at \
  textcolor rgb '#666666' font ',11'

at(a, m, overlap) = is('arithmetic', word(arithmetics, a)) && uses(m) && \
  is('overlap', overlap) ? microseconds * column('seconds') : NaN
step_name(a) = is('arithmetic', word(arithmetics, a)) && uses(2) && is('overlap', 'stable') ? sprintf(step_format(column('step')), column('step')) : ''
step_format(step) = sprintf('step %%.%df cm', int(ceil(-log10(step) - 0.01)))

plot "< awk -F, 'NR == 1 || $29 == 1' " . file \
    using (microseconds * column('seconds')):(worst('own_error_max')) \
    smooth unique with lines linetype 5 title 'Pareto front', \
  for [a = 1:4] for [m = 1:3] file using (at(a, m, 'stable')):(worst('own_error_max')) \
    with points pointtype filled[m] pointsize 0.65 linewidth 1 linecolor rgb colour[a] notitle, \
  for [a = 1:4] for [m = 1:3] file using (at(a, m, 'original')):(worst('own_error_max')) \
    with points pointtype open[m] pointsize 0.65 linewidth 1.2 linecolor rgb colour[a] notitle, \
  file using (46000):(worst('own_error_max')):(step_name(4)) with labels right \
    font ',11' textcolor rgb '#666666' notitle, \
  NaN with lines linecolor rgb 'white' title ' ', \
  for [a = 1:4] NaN with lines linewidth 6 linecolor rgb colour[a] title word(arithmetics, a), \
  NaN with lines linecolor rgb 'white' title ' ', \
  for [m = 1:3] NaN with points pointtype open[m] pointsize 0.65 linewidth 1.2 \
    linecolor rgb '#222222' title word(method_names, m), \
  NaN with lines linecolor rgb 'white' title ' ', \
  NaN with points pointtype filled[1] pointsize 0.65 linewidth 1 linecolor rgb '#222222' \
    title 'stable overlap', \
  NaN with points pointtype open[1] pointsize 0.65 linewidth 1.2 linecolor rgb '#222222' \
    title 'original overlap'
