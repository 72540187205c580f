# Polymethyl methacrylate held for ten minutes, at one position of the thesis.
height = 440
load 'style.gp'
outputs = '../../data/examples/effects/'
held = outputs . 'ten_minutes.curve.csv'
stopped = outputs . 'ten_minutes_approach.curve.csv'
set xlabel 'Time since loading (s)'
set ylabel 'Value over that at the end of loading'
set xrange [0:610]
set yrange [0.78:1.2]
set key at graph 0.98, 0.5 right center reverse Left
first(file, name) = real(system(sprintf("awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) " . \
  "if ($i == \"%s\") c = i } NR == 2 { print $c }' %s", name, file)))
area = first(held, 'area')
closing = first(held, 'compression')
force = first(stopped, 'load')
r = 0.8
tau = 100.0
plot held using 'time':(column('area') / area) with lines linetype 1 \
    title 'load held: contact area', \
  held using 'time':(column('compression') / closing) with lines linetype 2 \
    title 'load held: compression', \
  (1 / r - (1 / r - 1) * exp(-r * x / tau))**(2.0 / 3) with lines linecolor rgb '#222222' \
    linewidth 1 dashtype 3 title 'both, for a single contact', \
  stopped using 'time':(column('load') / force) with lines linetype 3 \
    title 'separation held: load'
