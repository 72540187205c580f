# Figure 28 of the thesis: the contact areas at position 56, to scale, on the models' outlines.
height = 760
load 'style.gp'
inch = 2.54
# The thesis gives the asperity surfaces, 3 in x 8 in and 3 in x 4 in; the models are 3.455 in wide.
# The margin at their ends is taken to be that at their sides.
model_width = 3.455 * inch
margin = (model_width - 3 * inch) / 2
lower_length = 8 * inch + 2 * margin
upper_length = 4 * inch + 2 * margin
shift = 5.6

# Summits in cm: NU in columns 1-5 of card 2, the summits in inches from card 5 on, NU upper ones
# first. The lower model is mirrored, the upper one displaced.
summits(lower) = sprintf("< awk 'NR == 2 { nu = substr($0, 1, 5) + 0 } " . \
  "NR > 4 && (NR > 4 + nu) == %d { print substr($0, 1, 6) \",\" substr($0, 7, 6) }' " . \
  "../../data/thesis.deck", lower)
# The contacts of the last step: x, y, area, load.
contacts = sprintf("< awk -F, 'NR == 1 { next } $4 != step { n = 0; step = $4 } " . \
  "{ row[n++] = $7 \",\" $8 \",\" $11 \",\" $14 } " . \
  "END { for (i = 0; i < n; i++) print row[i] }' %s/contacts_56.csv", data)
radius(area) = sqrt(area / pi)
ink(load) = load > 120 ? 0xFFFFFF : 0x000000

set palette defined (0 '#FDE725', 1 '#90D743', 2 '#35B779', 3 '#21918C', 4 '#31688E', \
  5 '#443983', 6 '#440154')
set cbrange [0:300]
set cbtics 50 scale 0.4 textcolor rgb '#333333'
set cblabel 'Load of a contact (N)' offset 2.2, 0
set style fill solid 1.0 noborder
set linetype 5 linecolor rgb '#777777' linewidth 1 pointtype 7 pointsize 0.25
set linetype 6 linecolor rgb blue linewidth 1 pointtype 1 pointsize 0.43
unset grid
set border 15
set multiplot

# Both axes of a panel have the same scale: its size in dots and its ranges go together.
set lmargin at screen 70.0 / width
set rmargin at screen 790.0 / width
set bmargin at screen 408.0 / height
set tmargin at screen (408 + 720 * 9.4 / 22.1) / height
set xrange [-0.3:21.8]
set yrange [-0.3:9.1]
set xlabel 'x (cm)'
set ylabel 'y (cm)' offset 0.6, 0
set xtics 2
set ytics 2
set key horizontal at screen 0.54, 0.972 center samplen 1 width 1
unset colorbox
set object 1 rectangle from 0, 0 to lower_length, model_width behind \
  fillcolor rgb '#F3F3F3' fillstyle solid border linecolor rgb '#777777'
set object 2 rectangle from shift, 0 to shift + upper_length, model_width behind \
  fillcolor rgb '#DCE6F2' fillstyle solid border linecolor rgb blue
half = 0.35
ax = 7.52
ay = 7.55
bx = 9.92
by = 2.17
set object 3 rectangle from ax - half, ay - half to ax + half, ay + half front \
  fillstyle empty border linecolor rgb '#222222'
set object 4 rectangle from bx - half, by - half to bx + half, by + half front \
  fillstyle empty border linecolor rgb '#222222'
set label 3 'lower model' at 0.3, 0.5 textcolor rgb '#555555'
set label 4 'upper model, moved by 5.6 cm' at shift + 0.3, 0.5 textcolor rgb blue
set label 1 'a' at ax + half + 0.12, ay front
set label 2 'b' at bx + half + 0.12, by front
plot summits(1) using ($1 * inch):(model_width - $2 * inch) with points linetype 5 \
    title 'lower summits', \
  summits(0) using ($1 * inch + shift):($2 * inch) with points linetype 6 \
    title 'upper summits', \
  contacts using 1:2:(radius($3)):4 with circles linecolor palette notitle, \
  contacts using 1:2:(radius($3)) with circles fillstyle empty \
    border linecolor rgb '#222222' linewidth 0.4 notitle, \
  NaN with points pointtype 7 pointsize 0.5 linecolor rgb '#35B779' title 'contacts, to scale'

unset key
unset label
unset object 3
unset object 4
set bmargin at screen 72.0 / height
set tmargin at screen 312.0 / height
set xtics 0.2
set ytics 0.2
set format '%.1f'
set linetype 5 pointsize 0.58
set linetype 6 pointsize 0.86
outlines = "contacts using 1:2:(radius($3)) with circles fillstyle empty " . \
  "border linecolor rgb 'white' linewidth 0.6"
zoom = "contacts using 1:2:(radius($3)):4 with circles linecolor palette, " . \
  outlines . ", " . \
  "summits(1) using ($1 * inch):(model_width - $2 * inch) with points linetype 5, " . \
  "summits(0) using ($1 * inch + shift):($2 * inch) with points linetype 6, " . \
  "contacts using 1:2:(sprintf('%.0f N', $4)):(ink($4)) with labels " . \
  "textcolor rgb variable font ',11'"

set lmargin at screen 70.0 / width
set rmargin at screen 310.0 / width
set title 'a' offset 0, -0.6
set xrange [ax - half:ax + half]
set yrange [ay - half:ay + half]
eval 'plot ' . zoom

set lmargin at screen 395.0 / width
set rmargin at screen 635.0 / width
set title 'b'
set xrange [bx - half:bx + half]
set yrange [by - half:by + half]
unset ylabel
set colorbox user origin 680.0 / width, 72.0 / height size 18.0 / width, 240.0 / height
set format cb '%g'
eval 'plot ' . zoom
unset multiplot
