# Common to all pictures: the form, fonts, colours and axes. A script sets `height` and loads this.
# Given with -e: data (folder of the CSVs), kind (svg or png), out (file to write).
width = 800
if (kind eq 'svg') {
  set terminal svg size width, height fixed enhanced font 'sans-serif,14' background 'white' \
    linewidth 1.2
} else {
  # Twice as many dots, for screens with fine dots; shown at the width of the SVG.
  set terminal pngcairo size 2 * width, 2 * height enhanced font 'DejaVu Sans,14' fontscale 1.5 \
    linewidth 2.4 pointscale 2.8 background 'white'
}
set output out
set encoding utf8
set datafile separator ','

# Paul Tol's high-contrast colours, safe for the colour-blind and in grey.
blue = 0x004488
yellow = 0xDDAA33
red = 0xBB5566
grey = 0x888888
set linetype 1 linecolor rgb yellow linewidth 2
set linetype 2 linecolor rgb red linewidth 2
set linetype 3 linecolor rgb blue linewidth 2
# The numbers that the thesis prints.
set linetype 4 linecolor rgb '#222222' linewidth 1 pointtype 6 pointsize 0.6

set border 3 linecolor rgb '#666666' linewidth 0.8
set tics nomirror out scale 0.6 textcolor rgb '#333333'
set grid linecolor rgb '#DDDDDD' linewidth 0.6 linetype 1
set key samplen 2.5 spacing 1.2 textcolor rgb '#333333'
set bmargin 3.6
set lmargin 11.5
set rmargin 3
set tmargin 1.5
