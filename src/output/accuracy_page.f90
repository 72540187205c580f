!> Accuracy and run time for a scene, as one page that opens anywhere: slide to an error, read the
!> fastest method and its time; the diagrams, and all methods as a table. It loads nothing; its
!> script is a few lines that read the data of the page.
module asperity_accuracy_page
  use asperity_html_page, only: begin_page, begin_section, end_page, put_table
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: not_computed, real64
  use asperity_method_study, only: method_table
  use asperity_method_totals, only: error_of_area
  use asperity_number_format, only: number_text
  use asperity_result_table, only: add_words, array_table
  use asperity_study_methods, only: family_words, of_input, of_theory
  use asperity_svg_plot, only: axis_over, svg_plot
  use asperity_text_buffer, only: text_buffer
  use asperity_version, only: version
  implicit none
  private

  public :: write_accuracy_page

  ! Smaller errors are drawn there, below the rounding of a double.
  real(real64), parameter :: least_drawn = 1.0e-17_real64
  ! Shorter times are below the resolution of the clock [s].
  real(real64), parameter :: least_time = 1.0e-9_real64

contains

  !> The whole page.
  subroutine write_accuracy_page(title, table, buffer)
    character(len=*), intent(in) :: title       !! the scene's name
    type(method_table), intent(in) :: table        !! all methods of a scene
    type(text_buffer), intent(inout) :: buffer  !! gets the page
    real(real64) :: error(size(table%rows)), own(size(table%rows))
    logical :: is_run(size(table%rows))

    associate (rows => table%rows)
      is_run = min(rows%seconds, rows%total%largest) > not_computed .and. &
               rows%method%family /= of_theory
      ! Nothing is known better than the reference.
      error = max(rows%total%largest, rows(table%reference)%own_estimate, least_drawn)
      own = max(rows%own%largest, least_drawn)
    end associate
    call begin_page('Accuracy and run time: ' // title, buffer, with_script=.true.)
    call buffer%line('<p>Error: largest relative error over the positions, of the load or, at ' // &
                     'a given load, of the compression. Time: all positions, one thread.</p>')
    call begin_section('choose', 'Fastest method for an error', buffer, .true.)
    call buffer%line('<p><label for="error">Error at most</label> ' // &
                     '<input id="error" type="range" min="-16" max="0" step="0.25" ' // &
                     'value="-2" style="width:100%"/></p>')
    call buffer%line('<p id="answer" aria-live="polite">This line needs ' // &
                     'the script of the page; the table below holds the same values.</p>')
    call begin_section('total', 'Error against time', buffer)
    call put_plot('error against the reference', 'total-plot', table, is_run, error, buffer)
    call begin_section('own', 'Error of each approximation', buffer)
    call buffer%line('<p>Steps and arithmetics against exact events in real64, effects ' // &
                     'against all effects of the scene, neighbours against the reference. ' // &
                     'Horizontal lines: uncertainty from the rounding of the input data; for ' // &
                     'a map one for its summits and one for its pixels.</p>')
    call put_plot('error of the approximation', 'own-plot', table, is_run .and. &
                  table%rows%own%largest > not_computed, own, buffer)
    call begin_section('methods', 'All methods', buffer)
    call put_methods(table, buffer)
    call buffer%line('<p>asperity ' // version // '</p>')
    call put_script(table, is_run, error, buffer)
    call end_page(buffer)
  end subroutine write_accuracy_page

  ! One diagram: a dot a method, the Pareto front joined, the error of the input across.
  subroutine put_plot(name, id, table, shown, error, buffer)
    character(len=*), intent(in) :: name, id
    type(method_table), intent(in) :: table
    logical, intent(in) :: shown(:)
    real(real64), intent(in) :: error(:)
    type(text_buffer), intent(inout) :: buffer
    type(svg_plot) :: plot
    real(real64), allocatable :: fast(:), level(:)
    real(real64) :: seconds(size(shown))
    integer, allocatable :: order(:)
    integer :: i

    if (.not. any(shown)) return
    seconds = max(table%rows%seconds, least_time)
    call buffer%line('<div id="' // id // '">')
    plot%axes(:2) = [axis_over('time', 's', pack(seconds, shown), .true.), &
                     axis_over(name, '', [pack(error, shown), 1.0_real64], .true.)]
    call plot%begin_plot(name // ' over time', buffer)
    if (id == 'total-plot') then
      ! The methods of the Pareto front, from the fastest on.
      fast = pack(table%rows%seconds, table%rows%on_front)
      level = pack(error, table%rows%on_front)
      allocate (order(size(fast)))
      call sort_keys(fast, order)
      call plot%add_curve(max(fast(order), least_time), level(order), buffer)
    end if
    do i = 1, size(table%rows)
      associate (row => table%rows(i))
        if (shown(i)) call plot%add_dot(seconds(i), error(i), &
          trim(family_words(row%method%family)) // ': ' // trim(row%method%name) // ', ' // &
          number_text(row%seconds, 2) // ' s, ' // number_text(error(i), 2), buffer)
        if (row%method%family == of_input .and. id == 'own-plot' .and. &
            row%own%largest > 0.0_real64) &
          call plot%add_curve([plot%axes(1)%low, plot%axes(1)%high], [error(i), error(i)], buffer)
      end associate
    end do
    call buffer%line('</svg></div>')
  end subroutine put_plot

  ! All methods, those that were not run with the reason.
  subroutine put_methods(table, buffer)
    type(method_table), intent(in) :: table
    type(text_buffer), intent(inout) :: buffer
    character(len=*), parameter :: heads(8) = [character(len=13) :: 'method', 'family', &
      'Pareto front', 'time [s]', 'error', 'of the area', 'approximation', 'not run']
    character(len=140) :: words(size(heads), size(table%rows))
    type(array_table) :: methods
    integer :: i

    do i = 1, size(table%rows)
      associate (row => table%rows(i))
        words(:, i) = [character(len=140) :: row%method%name, family_words(row%method%family), &
                       merge('*', ' ', row%on_front), number_text(row%seconds, 2), &
                       number_text(row%total%largest, 2), &
                       number_text(row%total%quantity(error_of_area), 2), &
                       number_text(row%own%largest, 2), '']
        if (row%is_reference) words(5:6, i) = 'reference'
        if (allocated(row%left_out)) words(8, i) = row%left_out
      end associate
    end do
    do i = 1, size(heads)
      call add_words(methods, trim(heads(i)), words(i, :))
    end do
    call put_table('methods; Pareto front: no other method is faster and more accurate', &
                   methods, buffer)
  end subroutine put_methods

  ! The data, and the script of the slider: the fastest method for an error, and for a tenth of it.
  subroutine put_script(table, is_run, error, buffer)
    type(method_table), intent(in) :: table
    logical, intent(in) :: is_run(:)
    real(real64), intent(in) :: error(:)
    type(text_buffer), intent(inout) :: buffer
    character(len=60) :: numbers
    integer :: i

    call buffer%line('<script>')
    call buffer%line('const methods=[')
    do i = 1, size(table%rows)
      if (.not. is_run(i)) cycle
      write (numbers, '(es23.15e3, ",", es23.15e3)') table%rows(i)%seconds, error(i)
      call buffer%line('["' // trim(table%rows(i)%method%name) // '",' // &
                       trim(adjustl(numbers)) // '],')
    end do
    call buffer%line('];')
    call buffer%line('const slider=document.getElementById("error"),' // &
                     'answer=document.getElementById("answer"),')
    call buffer%line('dots=document.querySelectorAll("#total-plot .dot");')
    call buffer%line('function fastest(e){let b=-1;methods.forEach((m,i)=>{if(e>=m[2])' // &
                     'if(b===-1||methods[b][1]>m[1])b=i});return b}')
    call buffer%line('function show(){const e=10**Number(slider.value),b=fastest(e),' // &
                     't=fastest(e/10),n="Error at most "+e.toExponential(1)+": ";')
    call buffer%line('dots.forEach((d,i)=>{d.setAttribute("r",i===b?7:3)});')
    call buffer%line('answer.textContent=b===-1?n+"no method.":n+methods[b][0]+", "+' // &
                     'methods[b][1].toPrecision(2)+" s, error "+methods[b][2].toExponential(1)+')
    call buffer%line('". A tenth of this error: "+(t===-1?"no method.":t===b?' // &
                     '"the same method.":methods[t][0]+", "+' // &
                     '(methods[t][1]/methods[b][1]).toPrecision(2)+" times the time.")}')
    call buffer%line('slider.addEventListener("input",show);show();')
    call buffer%line('</script>')
  end subroutine put_script

end module asperity_accuracy_page
