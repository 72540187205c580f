# Error against time a position: the front of the arithmetics, and the rungs of the model.
height = 480
load 'style.gp'
file = data . '/accuracy.csv'
ways = "< awk -F, 'NR == 1 || ($2 != \"model\" && $19 == 1)' " . file
microseconds = 1e6

# An error of zero, and one that is not known, have no place on a logarithmic axis.
floor_at = 1e-17
place(error) = error > floor_at ? error : floor_at

set logscale xy
set xlabel 'Run time for each position (µs)'
set ylabel 'Largest relative error of the load'
set xrange [2:1000000]
set yrange [1e-18:30]
set format x '10^{%T}'
set format y '10^{%T}'
set ytics 1e-15, 1000, 1 nomirror
unset mxtics
unset mytics
set ytics add ('0' floor_at)
set key at graph 0.40, 0.52 left top reverse Left
set arrow 1 from 2, floor_at to 1000000, floor_at nohead linecolor rgb '#999999' dashtype 3
set label 1 'zero error, drawn at 10^{-17}' at 2.5, 4 * floor_at \
  textcolor rgb '#666666' font ',11'

# The finest cells are what the others are measured against.
finest = microseconds * real(system("awk -F, 'END { print $5 }' " . file))
set arrow 2 from finest, 1e-18 to finest, 30 nohead linecolor rgb red dashtype 3
set label 2 'the finest cells' at finest * 1.6, 1e-11 rotate left textcolor rgb red font ',12'

# The reference, and the tolerance that gives the same cells, have no name.
name_of(mode) = mode eq 'off' ? 'independent' : mode eq 'auto' || mode eq 'boundary' ? \
  sprintf('%s %g', mode, column('tolerance')) : mode
shown = "< awk -F, 'NR == 1 || ($2 == \"model\" && $21 != \"\" && $22 != \"\" && " . \
  "!($20 == \"boundary\" && $21 > 0.005))' " . file
front = "< awk -F, 'NR == 1 || ($2 == \"model\" && $22 != \"\" && $20 != \"auto\")' " . file
on_cells(x) = strcol('interaction') eq 'boundary'
cost(x) = microseconds * column('seconds_per_position')
plot front using (cost(0)):'factor_max' with lines linetype 2 dashtype 2 linewidth 1 notitle, \
  shown using (cost(0)):'factor_max' with points linetype 2 pointtype 7 pointsize 0.7 \
    title 'model, against the finest cells', \
  shown using (cost(0)):'factor_max':(on_cells(0) ? '' : name_of(strcol('interaction'))) \
    with labels left offset 0.8, 0.6 font ',12' textcolor rgb red notitle, \
  shown using (cost(0)):'factor_max':(on_cells(0) ? name_of(strcol('interaction')) : '') \
    with labels right offset -0.8, -0.7 font ',12' textcolor rgb red notitle, \
  ways using (cost(0)):(place(column('load_max'))) with lines linetype 3 dashtype 2 linewidth 1 \
    notitle, \
  ways using (cost(0)):(place(column('load_max'))) with points linetype 3 pointtype 5 \
    pointsize 0.6 title 'arithmetic, against real128', \
  ways using (cost(0)):(place(column('load_max'))):'arithmetic' with labels left offset 0.9, 0.5 \
    font ',12' textcolor rgb blue notitle
