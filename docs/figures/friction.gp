# What friction adds to the vertical load, and the lateral force on the fixture.
height = 460
load 'style.gp'
set xlabel 'Displacement (cm)'
set ylabel 'Share of the vertical load (%)'
set xrange [0:10.1]
set yrange [0:11]
set key top right reverse Left
rubbed = data . '/friction.csv'
lateral = "sqrt(column('rig_force_x')**2 + column('rig_force_y')**2)"
plot rubbed using 'x_displacement':(100 * @lateral / column('vertical_load')) with points \
    linetype 2 pointtype 6 pointsize 0.8 title 'lateral force on the fixture', \
  rubbed using 'x_displacement':(100 * column('friction_influence')) with points linetype 3 \
    pointtype 7 pointsize 0.6 title 'vertical load added by friction, coefficient 0.1'
