# A ball past its elastic limit: load and area over those of Hertz at the same overlap.
height = 460
load 'style.gp'
outputs = '../../data/examples/effects/'
overlap = 1.1090941284170878e-4
force = 3.470072092352658e-4
area = 3.484321965974697e-4
set xlabel 'Overlap / overlap at first yield'
set ylabel 'Load, area / those of Hertz'
set logscale x
set xrange [1:130]
set xtics (1, 1.9, 3, 6, 10, 20, 50, 100)
set yrange [0.25:2.2]
set key at graph 0.03, 0.97 left top reverse Left
set object 1 rectangle from 1.9, graph 0 to 6, graph 1 behind fillcolor rgb '#F0F0F0' \
  fillstyle solid noborder
set label 1 'joined' at 3.38, 0.31 center textcolor rgb '#666666'
# First loadings only: from the largest overlap before to the next.
first = "< awk -F, 'NR == 1 { next } $4 > most { most = $4; print $4 \",\" $6 \",\" $7 }' " . \
  outputs . 'steel.curve.csv'
x(w) = w / overlap
set samples 400
plot 1 with lines linecolor rgb '#999999' dashtype 3 title 'Hertz', \
  first using (x($1)):($3 / area / x($1)) with lines linetype 1 title 'area', \
  first using (x($1)):($2 / force / x($1)**1.5) with lines linetype 3 title 'load', \
  [6:110] 1.40 * x**1.263 / x**1.5 with lines linetype 2 dashtype 2 \
    title 'load, Kogut and Etsion'
