# Two surfaces of five asperities each under one load: how near they come while one slides.
height = 420
load 'style.gp'
set xlabel 'Displacement of the upper surface (mm)'
set ylabel 'Separation of the reference planes (mm)'
set xrange [-0.05:2.05]
set offsets 0, 0, graph 0.1, graph 0.1
set key off
slide = data . '/slide.csv'
plot slide using 'x_displacement':'separation' with linespoints linetype 3 pointtype 7 pointsize 0.6, \
  slide using 'x_displacement':'separation':(sprintf('%d', column('contacts'))) with labels \
    offset 0, 1 textcolor rgb '#555555'
