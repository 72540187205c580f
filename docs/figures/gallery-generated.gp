# A random pair of models: the summits of both in plan, coloured by height.
height = 370
load 'style.gp'
set xlabel 'x (in)'
set ylabel 'y (in)'
set size ratio -1
set tmargin 3
set xrange [-0.1:8.1]
set yrange [-0.1:3.1]
set palette defined (0 '#FDE725', 1 '#35B779', 2 '#31688E', 3 '#440154')
set cblabel 'Height (in)'
set key horizontal at screen 0.5, 0.955 center
# NU in columns 1-5 of card 2, the summits from card 5 on, NU upper ones first.
summits(lower) = sprintf("< awk 'NR == 2 { nu = substr($0, 1, 5) + 0 } " . \
  "NR > 4 && (NR > 4 + nu) == %d { print substr($0, 1, 6) \",\" substr($0, 7, 6) \",\" " . \
  "substr($0, 13, 6) }' %s/generated.deck", lower, data)
plot summits(1) using 1:2:3 with points pointtype 7 pointsize 0.9 palette title 'lower model', \
  summits(0) using 1:2:3 with points pointtype 9 pointsize 1.1 palette title 'upper model'
