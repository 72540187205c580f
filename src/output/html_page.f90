!> Pieces of a page of HTML that stands alone: head with its style, escaped text, tables. A page is
!> well-formed XML, too; it loads nothing, and runs nothing but what stands in it.
module asperity_html_page
  use asperity_printable, only: printable_text
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: begin_page, end_page, begin_section, end_section
  public :: begin_table, put_row, end_table, put_lines
  public :: escaped_text

contains

  !> Everything before the first section.
  subroutine begin_page(title, buffer, with_script)
    character(len=*), intent(in) :: title         !! what the page is about, as it stands
    type(text_buffer), intent(inout) :: buffer    !! gets the page
    logical, intent(in), optional :: with_script  !! a script in the page may run
    character(len=:), allocatable :: script

    script = ''
    if (present(with_script)) script = '; script-src ''unsafe-inline'''

    call buffer%line('<!DOCTYPE html>')
    call buffer%line('<html lang="en">')
    call buffer%line('<head>')
    call buffer%line('<meta charset="utf-8"/>')
    call buffer%line('<meta http-equiv="Content-Security-Policy" ' // &
                     'content="default-src ''none''; img-src data:; ' // &
                     'style-src ''unsafe-inline''' // &
                     script // '"/>')
    call buffer%line('<meta name="viewport" content="width=device-width, initial-scale=1"/>')
    call buffer%line('<title>' // escaped_text(title) // '</title>')
    call put_style(buffer)
    call buffer%line('</head>')
    call buffer%line('<body>')
    call buffer%line('<main>')
    call buffer%line('<h1>' // escaped_text(title) // '</h1>')
  end subroutine begin_page

  ! Two sets of colours, each with a contrast of 4.5 or more of text to paper; one column of any
  ! width; what is too wide is scrolled by itself.
  subroutine put_style(buffer)
    type(text_buffer), intent(inout) :: buffer

    call buffer%line('<style>')
    call buffer%line(':root{color-scheme:light dark;--ink:#1b1f24;--paper:#ffffff;' // &
                     '--soft:#57606a;--line:#d0d7de;--mark:#0a58ca;--back:#f3f5f7;--warn:#8a4500}')
    call buffer%line('@media(prefers-color-scheme:dark){:root{--ink:#e6edf3;--paper:#0d1117;' // &
                     '--soft:#9aa4af;--line:#3d444d;--mark:#6cb6ff;--back:#161b22;' // &
                     '--warn:#f0b46a}}')
    call buffer%line('body{margin:0;background:var(--paper);color:var(--ink);' // &
                     'font:1rem/1.5 system-ui,sans-serif}')
    call buffer%line('main{max-width:75rem;margin:0 auto;padding:1rem}')
    call buffer%line('h1{font-size:clamp(1.1rem,5vw,1.5rem);line-height:1.25;' // &
                     'overflow-wrap:anywhere}')
    call buffer%line('h2{font-size:1.2rem;margin:2rem 0 .5rem}')
    call buffer%line('p,li,dd,summary{overflow-wrap:anywhere}')
    call buffer%line('p,dd{max-width:60rem}')
    call buffer%line('dt{font-weight:600}')
    call buffer%line('a{color:var(--mark)}')
    call buffer%line('.scroll{overflow:auto;max-height:48rem}')
    call buffer%line('table{border-collapse:collapse;font-variant-numeric:tabular-nums}')
    call buffer%line('caption{text-align:left;color:var(--soft)}')
    call buffer%line('th,td{padding:.15rem .75rem .15rem 0;' // &
                     'border-bottom:1px solid var(--line);text-align:right;white-space:nowrap}')
    call buffer%line('th:first-child{text-align:left;white-space:normal}')
    call buffer%line('thead th{position:sticky;top:0;background:var(--paper)}')
    call buffer%line('tbody th{font-weight:400}')
    call buffer%line('pre{overflow:auto;max-height:30rem;padding:.75rem;' // &
                     'background:var(--back);font-size:.85rem}')
    call buffer%line('summary{cursor:pointer;padding:.25rem 0}')
    call buffer%line('.warn{border-left:4px solid var(--warn);padding-left:.75rem}')
    call buffer%line('.plots{display:grid;gap:1rem;' // &
                     'grid-template-columns:repeat(auto-fit,minmax(min(100%,22rem),1fr))}')
    call buffer%line('svg{display:block;width:100%;max-width:36rem;height:auto;' // &
                     'margin-bottom:.5rem}')
    call buffer%line('text{fill:var(--ink);font:13px system-ui,sans-serif}')
    call buffer%line('.grid{stroke:var(--line);fill:none}')
    call buffer%line('.curve{stroke:var(--mark);stroke-width:1.5;stroke-linejoin:round;fill:none}')
    call buffer%line('.dot{fill:var(--mark)}')
    call buffer%line('.arrow{fill:var(--ink)}')
    call buffer%line('.bar{stroke:var(--ink);fill:none}')
    call buffer%line('.upper,.lower{stroke:var(--soft);fill:none}')
    call buffer%line('.upper.outline{stroke-dasharray:6 3}')
    call buffer%line('.lower.summits{stroke-width:3.5;stroke-linecap:round}')
    call buffer%line('.patch{stroke:var(--mark);fill:var(--mark);fill-opacity:.35}')
    call buffer%line('.many{stroke-width:.3}')
    call buffer%line('.note{display:none;font-size:11px}')
    call buffer%line('.patch:hover,.patch:focus{stroke:var(--warn);fill:var(--warn);outline:none}')
    call buffer%line('g:hover>.note,g:focus>.note{display:block;stroke:none;fill-opacity:1}')
    call buffer%line('svg:hover g:focus:not(:hover)>.note{display:none}')
    call buffer%line(':focus-visible{outline:2px solid var(--mark);outline-offset:2px}')
    call buffer%line('</style>')
  end subroutine put_style

  !> Everything behind the last section.
  subroutine end_page(buffer)
    type(text_buffer), intent(inout) :: buffer  !! gets the page

    call buffer%line('</main>')
    call buffer%line('</body>')
    call buffer%line('</html>')
  end subroutine end_page

  !> A part of the page that a reader of screens can go to.
  subroutine begin_section(name, heading, buffer)
    character(len=*), intent(in) :: name        !! one word, another one for every section
    character(len=*), intent(in) :: heading     !! as it stands
    type(text_buffer), intent(inout) :: buffer  !! gets the page

    call buffer%line('<section aria-labelledby="' // name // '">')
    call buffer%line('<h2 id="' // name // '">' // escaped_text(heading) // '</h2>')
  end subroutine begin_section

  !> Its end.
  subroutine end_section(buffer)
    type(text_buffer), intent(inout) :: buffer  !! gets the page

    call buffer%line('</section>')
  end subroutine end_section

  !> A table that scrolls by itself, with the keyboard, too.
  subroutine begin_table(caption, headers, buffer)
    character(len=*), intent(in) :: caption      !! what it holds, as it stands
    character(len=*), intent(in) :: headers(:)   !! of its columns; the first heads the rows
    type(text_buffer), intent(inout) :: buffer   !! gets the page
    integer :: i

    call buffer%line('<div class="scroll" role="region" tabindex="0" aria-label="' // &
                     escaped_text(caption) // '">')
    call buffer%line('<table>')
    call buffer%line('<caption>' // escaped_text(caption) // '</caption>')
    call buffer%append('<thead><tr>')
    do i = 1, size(headers)
      call buffer%append('<th scope="col">' // escaped_text(trim(headers(i))) // '</th>')
    end do
    call buffer%line('</tr></thead>')
    call buffer%line('<tbody>')
  end subroutine begin_table

  !> A row, as many cells as the table has headers.
  subroutine put_row(cells, buffer)
    character(len=*), intent(in) :: cells(:)    !! as they stand
    type(text_buffer), intent(inout) :: buffer  !! gets the page
    integer :: i

    call buffer%append('<tr><th scope="row">' // escaped_text(trim(cells(1))) // '</th>')
    do i = 2, size(cells)
      call buffer%append('<td>' // escaped_text(trim(cells(i))) // '</td>')
    end do
    call buffer%line('</tr>')
  end subroutine put_row

  !> The end of a table.
  subroutine end_table(buffer)
    type(text_buffer), intent(inout) :: buffer  !! gets the page

    call buffer%line('</tbody>')
    call buffer%line('</table>')
    call buffer%line('</div>')
  end subroutine end_table

  !> Lines of text as they were written; `label` says what they are.
  subroutine put_lines(label, text, buffer)
    character(len=*), intent(in) :: label       !! as it stands
    character(len=*), intent(in) :: text        !! lines, of any bytes
    type(text_buffer), intent(inout) :: buffer  !! gets the page
    integer :: first, last

    call buffer%line('<pre role="region" tabindex="0" aria-label="' // escaped_text(label) // '">')
    first = 1
    do while (first <= len(text))
      last = first + scan(text(first:), new_line('a')) - 2
      if (last < first - 1) last = len(text)
      ! A carriage return before the end of a line is a part of that end.
      call buffer%line(escaped_text(text(first:last - merge(1, 0, &
                                                            ends_with_return(text(first:last))))))
      first = last + 2
    end do
    call buffer%line('</pre>')
  end subroutine put_lines

  pure logical function ends_with_return(line)
    character(len=*), intent(in) :: line

    ends_with_return = .false.
    if (len(line) > 0) ends_with_return = iachar(line(len(line):)) == 13
  end function ends_with_return

  !> One line of text for a page, between tags or in quotes: what has a meaning there is written by
  !> name, a tab is a blank, what cannot be shown is a question mark.
  pure function escaped_text(text) result(safe)
    character(len=*), intent(in) :: text    !! text of any bytes
    character(len=:), allocatable :: safe   !! a piece of a page
    type(text_buffer) :: buffer
    character(len=len(text)) :: shown
    integer :: i

    shown = text
    do i = 1, len(shown)
      if (iachar(shown(i:i)) == 9) shown(i:i) = ' '
    end do
    shown = printable_text(shown)
    do i = 1, len(shown)
      select case (shown(i:i))
      case ('&')
        call buffer%append('&amp;')
      case ('<')
        call buffer%append('&lt;')
      case ('>')
        call buffer%append('&gt;')
      case ('"')
        call buffer%append('&quot;')
      case default
        call buffer%append(shown(i:i))
      end select
    end do
    safe = buffer%text()
  end function escaped_text

end module asperity_html_page
