# Contact areas of a measured height map under a flat at three nominal pressures.
height = 270
load 'style.gp'
set multiplot layout 1, 3
set size ratio -1
set xrange [0:127]
set yrange [0:95]
set xtics 50
set ytics 50
set lmargin 7.5
set rmargin 0.5
set bmargin 4
set tmargin 2.5
unset key
unset grid
unset colorbox
set palette defined (0 '#222222', 1 '#FFFFFF')
set xlabel 'x (um)' offset 0, 0.5
set ylabel 'y (um)' offset 1.5, 0
do for [pressure in '50 200 600'] {
  set title sprintf('nominal pressure %s MPa', pressure)
  plot '../../data/examples/summits/smooth.sdf' binary skip=81 array=(128,96) format='%int16' \
      endian=little with image, \
    sprintf('%s/patches-%s.csv', data, pressure) using 'x':'y':'contact_radius' with circles \
      fillstyle solid 0.75 noborder linecolor rgb red
}
unset multiplot
