# Two spheres pressed together: load against compression, and Hertz by hand.
height = 420
load 'style.gp'
set xlabel 'Compression (unit of length of the scene)'
set ylabel 'Load (unit of force of the scene)'
set xrange [0:0.0105]
set yrange [0:*]
set key left top Left reverse
pair = data . '/pair.csv'
# Radii 5 and 10, one modulus of 200e3 and Poisson's ratio 0.3 for both.
radius = 1 / (1 / 5.0 + 1 / 10.0)
modulus = 200e3 / (2 * (1 - 0.3**2))
hertz(d) = 4.0 / 3.0 * modulus * sqrt(radius) * d**1.5
plot hertz(x) with lines linetype 1 linewidth 5 title 'Hertz', \
  pair using 'compression':'load' with linespoints linetype 3 pointtype 7 pointsize 0.4 \
    title 'asperity'
