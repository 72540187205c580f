# The sweep of the thesis: load at the limit and number of contacts at every position.
height = 480
load 'style.gp'
set xlabel 'Displacement of the upper model (cm)'
set ylabel 'Load at the limit (N)'
set y2label 'Contacts'
set rmargin 9
set border 11
set xrange [0:10.1]
set yrange [0:1500]
set y2range [0:42]
set y2tics 2 out scale 0.6 textcolor rgb '#333333'
set y2tics ('0' 0, '2' 2, '4' 4, '6' 6, '8' 8)
set key left top Left reverse
positions = data . '/sweep.csv'
plot positions using 'x_displacement':'load' with lines linetype 3 title 'load', \
  positions using 'x_displacement':'contacts' axes x1y2 with steps linetype 1 title 'contacts'
