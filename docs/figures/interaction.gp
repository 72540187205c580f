# Load of the contacts together over load of each alone, at the positions of the thesis.
height = 460
load 'style.gp'
set xlabel 'Displacement (cm)'
set ylabel 'Load with interaction / load of isolated contacts'
set xrange [0:10.1]
set yrange [0.74:1.02]
set key at graph 0.5, 0.42 center reverse Left
set datafile separator ','
coupled = data . '/coupled.csv'
cells = data . '/boundary.csv'
truth = '../../reference_output/boundary/factors.csv'
# Positions with overlapping contact circles are named.
plot 1 with lines linecolor rgb '#999999' dashtype 3 title 'isolated contacts', \
  coupled using 'x_displacement':'factor' with points linetype 1 pointtype 7 pointsize 0.5 \
    title 'coupled', \
  cells using 'x_displacement':'factor' with points linetype 2 pointtype 6 pointsize 1.0 \
    title 'boundary elements', \
  truth using (column('position') / 10):'factor' with points linetype 4 pointtype 2 pointsize 0.6 \
    title 'independent evaluation', \
  truth using (column('overlapping_circles') > 0 ? column('position') / 10 : NaN): \
    'factor':'position' with labels offset 2.2, 0 notitle
