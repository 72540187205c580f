# Figure 11 of the thesis: decrease of approach against load.
height = 520
load 'style.gp'
load 'curves.gp'
set logscale xy
set xlabel 'Total load (N)'
set ylabel 'Decrease of approach (cm)'
set xrange [1:2000]
set yrange [0.0002:0.02]
set format y '%g'
set key top left reverse Left
touch(letter) = system(sprintf("awk -F, 'NR == 2 { print $3 }' %s", printed(letter))) + 0
plot for [k = 1:3] curve(word('13 55 56', k)) using 'load':'decrease' \
    with lines linetype k title label(word('1.3 5.5 5.6', k)), \
  for [k = 1:3] letter = word('a b c', k) printed(letter) \
    using (load_of_total(strcol('kind'), strcol('load'))):(touch(letter) - column('approach')) \
    with points linetype k pointsize 0.8 linewidth 1 notitle, \
  NaN with points pointtype 6 pointsize 0.8 linecolor rgb '#333333' title 'printed in the thesis'
