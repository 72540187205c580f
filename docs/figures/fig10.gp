# Figure 10 of the thesis: number of contacts against load.
height = 460
load 'style.gp'
load 'curves.gp'
set xlabel 'Total load (N)'
set ylabel 'Contacts'
set xrange [0:1450]
set yrange [0:9]
set ytics 1
set key at graph 0.97, 0.30 right
plot for [k = 1:3] curve(word('13 55 56', k)) using 'load':'contacts' \
  with steps linetype k title label(word('1.3 5.5 5.6', k))
