# The first page of Table VIIA as the original program prints it, on the paper of a line printer.
# Reads report.txt: the lines of the page, each between double quotes.
file = data . '/report.txt'
lines = system('wc -l < ' . file) + 0
pitch = 17
top = 2 * pitch
height = pitch * lines + 2 * top
load 'style.gp'
monospaced = kind eq 'svg' ? 'monospace,12' : 'DejaVu Sans Mono,12'

unset border
unset tics
unset grid
unset key
set lmargin at screen 0
set rmargin at screen 1
set bmargin at screen 0
set tmargin at screen 1
# Dots from the upper left corner.
set xrange [0:width]
set yrange [height:0]
strip = 36

# Pale green bars of two lines, the holes of the two edges every half inch of three lines.
do for [bar = 0:lines / 4] {
  set object rectangle behind from strip, top + 4 * bar * pitch \
    to width - strip, top + (4 * bar + 2) * pitch fillcolor rgb '#E6F2E8' fillstyle solid noborder
}
do for [hole = 0:(height - pitch) / (3 * pitch)] {
  do for [x in sprintf('%d %d', strip / 2, width - strip / 2)] {
    set object circle at x + 0, (3 * hole + 1.5) * pitch size 5 \
      fillcolor rgb '#E4E4E4' fillstyle solid border linecolor rgb '#BBBBBB'
  }
}
do for [x in sprintf('%d %d', strip, width - strip)] {
  set arrow from x + 0, 0 to x + 0, height nohead linecolor rgb '#CCCCCC' linewidth 0.6 dashtype 3
}
plot file using (strip + 4):(top + ($0 + 0.5) * pitch):1 with labels left noenhanced \
  font monospaced textcolor rgb '#222222'
