# Common to Figures 10, 11 and 12: where the three curves and the printed tables are.
curve(position) = sprintf('%s/curve_%s.csv', data, position)
printed(letter) = sprintf('../../reference_output/thesis/table_vii%s.csv', letter)
label(x) = sprintf('x = %s cm', x)

# Printed numbers: the total rows with a load; blank and illegible cells give no point.
number(text) = (strlen(text) > 0 && text ne '?') ? real(text) : NaN
load_of_total(kind, load) = (kind eq 'total' && number(load) > 0) ? number(load) : NaN
