# Condition number against error over the hard cases, by arithmetic: stable and original overlap.
height = 760
load 'style.gp'
file = data . '/stability.csv'
arithmetics = 'ibm370 real32 real64 real128'
# What an operation may lose: a hexadecimal digit cut, half a unit of the last place; results of
# real128 are written as doubles.
array unit[4] = [16.0**-5, 2.0**-24, 2.0**-53, 2.0**-113]
written = 2.0**-53
array colour[4] = [red, yellow, blue, 0x222222]
edge = 1e19
least = 2e-18
bound(a, condition) = a == 4 ? (unit[4] * condition > written ? unit[4] * condition : written) \
  : unit[a] * condition
at_x(condition) = condition < 1e18 ? condition : edge
at_y(error) = error > least ? error : least
of(a, formula) = strcol('arithmetic') eq word(arithmetics, a) && strcol('formula') eq formula ? \
  at_y(column('error')) : NaN
set datafile missing NaN
set logscale xy
set xrange [0.5:1e20]
set yrange [1e-18:1e3]
set tmargin 2
set format x '10^{%T}'
set format y '10^{%T}'
set xtics 1, 1e4, 1e16
set xtics add ('more' edge)
set ytics 1e-16, 1e4, 1
unset mxtics
unset mytics
set samples 400
set multiplot layout 2, 2
set lmargin 8
set rmargin 1.5
set key at graph 0.98, 0.03 right bottom noreverse Right samplen 1.5 spacing 1.05 font ',11'
do for [a = 1:4] {
  set xlabel (a > 2 ? 'Condition number' : '')
  set ylabel (a % 2 == 1 ? 'Largest relative error of a total' : '') offset 1
  set title word(arithmetics, a) offset 0, -0.8 textcolor rgb '#333333'
  if (a > 1) { set key off }
  plot bound(a, x) with lines linewidth 1.5 linecolor rgb '#999999' \
      title 'condition times roundoff', \
    file using (at_x(column('condition'))):(of(a, 'original')) with points pointtype 6 \
      pointsize 0.7 linewidth 1.2 linecolor rgb colour[a] title 'original overlap', \
    file using (at_x(column('condition'))):(of(a, 'stable')) with points pointtype 7 \
      pointsize 0.55 linewidth 1 linecolor rgb colour[a] title 'stable overlap'
}
unset multiplot
