!> Pieces of a page of HTML that stands alone: head with its style, escaped text, tables. A page is
!> well-formed XML, too; it loads nothing, and runs nothing but what stands in it.
module asperity_html_page
  use asperity_input_text, only: replaced_text
  use asperity_number_format, only: number_text
  use asperity_printable, only: printable_text
  use asperity_problems, only: decimal_text
  use asperity_result_table, only: array_column, array_table, place_of
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: begin_page, end_page, begin_section
  public :: put_table, put_lines, put_each_line, escaped_text

  ! Two sets of colours, each with a contrast of 4.5 or more of text to paper; one column of any
  ! width; what is too wide is scrolled by itself.
  character(len=*), parameter :: nl = new_line('a'), style = &
    ':root{color-scheme:light dark;--ink:#1b1f24;--paper:#ffffff;--soft:#57606a;' // &
    '--line:#d0d7de;--mark:#0a58ca;--back:#f3f5f7;--warn:#8a4500}' // nl // &
    '@media(prefers-color-scheme:dark){:root{--ink:#e6edf3;--paper:#0d1117;' // &
    '--soft:#9aa4af;--line:#3d444d;--mark:#6cb6ff;--back:#161b22;--warn:#f0b46a}}' // nl // &
    'body{margin:0;background:var(--paper);color:var(--ink);font:1rem/1.5 system-ui,' // &
    'sans-serif}main{max-width:75rem;margin:0 auto;padding:1rem}' // nl // &
    'h1{font-size:clamp(1.1rem,5vw,1.5rem);line-height:1.25;overflow-wrap:anywhere}' // &
    'h2{font-size:1.2rem;margin:2rem 0 .5rem}' // nl // &
    'p,li,dd,summary{overflow-wrap:anywhere}p,dd{max-width:60rem}dt{font-weight:600}' // nl // &
    '.scroll{overflow:auto;max-height:48rem}' // &
    'table{border-collapse:collapse;font-variant-numeric:tabular-nums}' // nl // &
    'caption{text-align:left;color:var(--soft)}' // &
    'th,td{padding:.15rem .75rem .15rem 0;border-bottom:1px solid var(--line);' // &
    'text-align:right;white-space:nowrap}' // &
    'th:first-child{text-align:left;white-space:normal}' // nl // &
    'thead th{position:sticky;top:0;background:var(--paper)}tbody th{font-weight:400}' // nl // &
    'pre{overflow:auto;max-height:30rem;padding:.75rem;background:var(--back);' // &
    'font-size:.85rem}summary{cursor:pointer;padding:.25rem 0}' // nl // &
    '.warn{border-left:4px solid var(--warn);padding-left:.75rem}' // &
    '.plots{display:grid;gap:1rem;grid-template-columns:repeat(auto-fit,' // &
    'minmax(min(100%,22rem),1fr))}' // nl // &
    'svg{display:block;width:100%;max-width:36rem;height:auto;margin-bottom:.5rem}' // nl // &
    'text{fill:var(--ink);font:13px system-ui,sans-serif}.grid{stroke:var(--line);fill:none}' // &
    '.curve{stroke:var(--mark);stroke-width:1.5;stroke-linejoin:round;fill:none}' // nl // &
    '.dot{fill:var(--mark)}.arrow{fill:var(--ink)}.bar{stroke:var(--ink);fill:none}' // nl // &
    '.upper,.lower{stroke:var(--soft);fill:none}.upper.outline{stroke-dasharray:6 3}' // nl // &
    '.lower.summits{stroke-width:3.5;stroke-linecap:round}' // &
    '.patch{stroke:var(--mark);fill:var(--mark);fill-opacity:.35}.many{stroke-width:.3}' // nl // &
    '.note{display:none;font-size:11px}' // &
    '.patch:hover,.patch:focus{stroke:var(--warn);fill:var(--warn);outline:none}' // nl // &
    'g:hover>.note,g:focus>.note{display:block;stroke:none;fill-opacity:1}' // &
    'svg:hover g:focus:not(:hover)>.note{display:none}' // nl // &
    ':focus-visible{outline:2px solid var(--mark);outline-offset:2px}'

contains

  !> Everything before the first section.
  subroutine begin_page(title, buffer, with_script)
    character(len=*), intent(in) :: title         !! what the page is about, as it stands
    type(text_buffer), intent(inout) :: buffer    !! gets the page
    logical, intent(in), optional :: with_script  !! a script in the page may run

    call buffer%append('<!DOCTYPE html>' // nl // '<html lang="en">' // nl // '<head>' // nl // &
                       '<meta charset="utf-8"/>' // nl // &
                       '<meta http-equiv="Content-Security-Policy" content="default-src ' // &
                       '''none''; img-src data:; style-src ''unsafe-inline''')
    if (present(with_script)) call buffer%append('; script-src ''unsafe-inline''')
    call buffer%line('"/>' // nl // '<meta name="viewport" content="width=device-width, ' // &
                     'initial-scale=1"/>' // nl // '<title>' // escaped_text(title) // &
                     '</title>' // nl // '<style>' // nl // style // nl // '</style>' // nl // &
                     '</head>' // nl // '<body>' // nl // '<main>' // nl // '<h1>' // &
                     escaped_text(title) // '</h1>')
  end subroutine begin_page

  !> Everything behind the last section.
  subroutine end_page(buffer)
    type(text_buffer), intent(inout) :: buffer  !! gets the page

    call buffer%line('</section>' // nl // '</main>' // nl // '</body>' // nl // '</html>')
  end subroutine end_page

  !> A part of the page that a reader of screens can go to; it ends where the next one begins.
  subroutine begin_section(name, heading, buffer, is_first)
    character(len=*), intent(in) :: name        !! one word, another one for every section
    character(len=*), intent(in) :: heading     !! as it stands
    type(text_buffer), intent(inout) :: buffer  !! gets the page
    logical, intent(in), optional :: is_first   !! present: no section is before it

    if (.not. present(is_first)) call buffer%line('</section>')
    call buffer%line('<section aria-labelledby="' // name // '">' // nl // '<h2 id="' // name // &
                     '">' // escaped_text(heading) // '</h2>')
  end subroutine begin_section

  !> A table that scrolls by itself, with the keyboard, too. Its first column heads the rows.
  subroutine put_table(caption, table, buffer, wanted, most_rows)
    character(len=*), intent(in) :: caption      !! what it holds, as it stands
    type(array_table), intent(in) :: table       !! columns of numbers and words, as they stand
    type(text_buffer), intent(inout) :: buffer   !! gets the page
    character(len=*), intent(in), optional :: wanted(:)  !! columns, if there; absent: all
    integer, intent(in), optional :: most_rows           !! more are left out; absent: all are there
    integer, allocatable :: columns(:)
    integer :: i, last, row

    allocate (columns(0))
    columns = [(i, i=1, size(table%columns))]
    if (present(wanted)) columns = [(place_of(table, wanted(i)), i=1, size(wanted))]
    columns = pack(columns, columns > 0)
    last = table%rows
    if (present(most_rows)) last = min(last, most_rows)
    call buffer%append('<div class="scroll" role="region" tabindex="0" aria-label="' // &
                       escaped_text(caption) // '">' // nl // '<table><caption>' // &
                       escaped_text(caption) // '</caption>' // nl // '<thead><tr>')
    do i = 1, size(columns)
      call buffer%append('<th scope="col">' // escaped_text(table%columns(columns(i))%name) // &
                         '</th>')
    end do
    call buffer%line('</tr></thead>' // nl // '<tbody>')
    do row = 1, last
      call buffer%append('<tr><th scope="row">' // cell_text(table%columns(columns(1))) // &
                         '</th>')
      do i = 2, size(columns)
        call buffer%append('<td>' // cell_text(table%columns(columns(i))) // '</td>')
      end do
      call buffer%line('</tr>')
    end do
    call buffer%line('</tbody></table></div>')

  contains

    function cell_text(column) result(text)
      type(array_column), intent(in) :: column
      character(len=:), allocatable :: text

      if (allocated(column%reals)) then
        text = number_text(column%reals(row))
      else if (column%name == 'limit_reached') then
        text = trim(merge('yes', 'no ', column%wholes(row) > 0))
      else if (allocated(column%wholes)) then
        text = decimal_text(column%wholes(row))
      else
        text = escaped_text(trim(transfer(column%letters(:, row), &
                                          repeat('a', size(column%letters, 1)))))
      end if
    end function cell_text

  end subroutine put_table

  !> Lines of text as they were written; `label` says what they are.
  subroutine put_lines(label, text, buffer)
    character(len=*), intent(in) :: label       !! as it stands
    character(len=*), intent(in) :: text        !! lines, of any bytes
    type(text_buffer), intent(inout) :: buffer  !! gets the page

    call buffer%line('<pre role="region" tabindex="0" aria-label="' // escaped_text(label) // '">')
    call put_each_line(text, '', '', buffer)
    call buffer%line('</pre>')
  end subroutine put_lines

  !> Each line of a text between two pieces.
  subroutine put_each_line(text, begin, end, buffer)
    character(len=*), intent(in) :: text        !! lines, of any bytes
    character(len=*), intent(in) :: begin, end  !! pieces of the page before and behind a line
    type(text_buffer), intent(inout) :: buffer  !! gets the page
    integer :: first, last, next

    first = 1
    do while (first <= len(text))
      last = first + scan(text(first:) // nl, nl) - 2
      next = last + 2
      ! A carriage return before the end of a line is a part of that end.
      if (last >= first) last = last - merge(1, 0, text(last:last) == achar(13))
      call buffer%line(begin // escaped_text(text(first:last)) // end)
      first = next
    end do
  end subroutine put_each_line

  !> One line of text for a page, between tags or in quotes: what has a meaning there is written by
  !> name, a tab is a blank, what cannot be shown is a question mark.
  pure function escaped_text(text) result(safe)
    character(len=*), intent(in) :: text    !! text of any bytes
    character(len=:), allocatable :: safe   !! a piece of a page
    character(len=*), parameter :: letters = '&<>"', names(4) = [character(len=6) :: '&amp;', &
      '&lt;', '&gt;', '&quot;']
    integer :: i

    safe = printable_text(replaced_text(text, achar(9), ' '))
    do i = 1, len(letters)
      safe = replaced_text(safe, letters(i:i), trim(names(i)))
    end do
  end function escaped_text

end module asperity_html_page
