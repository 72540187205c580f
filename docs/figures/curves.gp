# Common to Figures 10, 11 and 12: the three curves and, beside them, the printed tables.
positions = '13 55 56'
displacements = '1.3 5.5 5.6'
tables = 'a b c'
curve(k) = sprintf('%s/curve_%s.csv', data, word(positions, k))
title_of(k) = sprintf('x = %s cm', word(displacements, k))

# The totals of Table VIIA, B or C as load, contacts, decrease of approach, area; a printed load
# of zero and an illegible area (`?`) are left out.
printed(k) = "< awk -F, 'NR == 2 { touch = $3 } $2 == \"contact\" { contacts = $4; at = $3 } " . \
  "$2 == \"total\" && $12 > 0 { print $12 + 0 \",\" contacts \",\" touch - at \",\" $9 }' " . \
  sprintf('../../reference_output/thesis/table_vii%s.csv', word(tables, k))
