# Figure 10 of the thesis: number of contacts against load.
height = 460
load 'style.gp'
load 'curves.gp'
set xlabel 'Total load (N)'
set ylabel 'Contacts'
set xrange [0:1500]
set yrange [0:9]
set ytics 1
set key at graph 0.99, 0.32 right reverse Left
# The states at which the number changes, and the last.
changes(k) = "< awk -F, '$5 != count { print } { count = $5; last = $0 } END { print last }' " . \
  curve(k)
# Lines that run together differ in width.
plot for [k = 1:3] changes(k) using 'load':'contacts' with steps linetype k \
    linewidth 6 - 1.5 * k title title_of(k), \
  for [k = 1:3] printed(k) using 1:2 with points linetype 4 notitle, \
  NaN with points linetype 4 title 'printed in the thesis'
