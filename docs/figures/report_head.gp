# The first page of Table VIIA as the original program prints it, on line printer paper.
# Reads report.txt: lines of the report, each between double quotes.
file = data . '/report.txt'
stats file using (1) nooutput
lines = STATS_records
pitch = 17.0
top = 24
height = int(lines * pitch) + 2 * top
