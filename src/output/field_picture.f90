!> Plans of a contact field, pressure or gap, and of a height map with its summits: values as
!> colours, with axes, colour bar and scale bar.
module asperity_field_picture
  use asperity_contact_field, only: contact_field
  use asperity_height_map, only: height_map, is_measured
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: not_computed, real64
  use asperity_map_summits, only: map_summits
  use asperity_number_format, only: count_text, number_text
  use asperity_problems, only: decimal_text
  use asperity_svg_plot, only: plot_axis, side_of_plan, svg_plot
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: draw_map, draw_plan
  public :: plan_of_gap, plan_of_pressure, plan_of_traction

  !> Quantities shown as colours.
  integer, parameter :: plan_of_pressure = 1, plan_of_gap = 2, plan_of_traction = 3

  ! Longer side of the map in a file of its own, points; pixels of its image at most, of a map and
  ! of a field, and on a page.
  integer, parameter :: width_of_file = 512, pixels_of_field = 1024, pixels_of_page = 256
  ! The first and the last colour of heights are so many deviations from the mean.
  real(real64), parameter :: most_deviations = 3.0_real64
  ! More dots make the file large: the highest summits are drawn. Smaller dots from a number on.
  integer, parameter :: most_dots = 20000, many_dots = 2000
  ! Significant digits of the greatest pixel.
  integer, parameter :: digits_of_pixel = 4

contains

  !> Draws the pressure, the gap or the traction of a field in plan, in coordinates of the field.
  subroutine draw_plan(field, quantity, label, units, is_file, buffer)
    type(contact_field), intent(in) :: field      !! of one state
    integer, intent(in) :: quantity               !! one of the `plan_of_` numbers
    character(len=*), intent(in) :: label         !! what it shows; the title of a file
    character(len=*), intent(in) :: units(2)      !! of length and pressure; blank: not known
    logical, intent(in) :: is_file                !! a file of its own, not a part of a page
    type(text_buffer), intent(inout) :: buffer    !! gets the drawing, an SVG
    character(len=*), parameter :: names(3) = [character(len=8) :: 'pressure', 'gap', 'traction']
    character(len=*), parameter :: blanks(3) = [character(len=10) :: 'no contact', 'contact', &
      'no contact']
    type(svg_plot) :: plot
    real(real64), allocatable :: mean(:, :)
    character(len=:), allocatable :: note

    if (is_file) plot%title = label
    associate (most => merge(pixels_of_field, pixels_of_page, is_file))
      if (quantity == plan_of_pressure) call average_squares(field%pressure, most, mean, note)
      if (quantity == plan_of_gap) call average_squares(field%gap, most, mean, note)
      if (quantity == plan_of_traction) call average_squares(field%traction, most, mean, note)
    end associate
    call set_axes(plot, field%origin, field%pixel_spacing, shape(field%gap), units(1))
    plot%axes(3) = plot_axis(names(quantity), units(merge(1, 2, quantity == plan_of_gap)), &
                             0.0_real64, max(0.0_real64, maxval(mean)))
    plot%notes = 1 + merge(1, 0, note /= '') + merge(1, 0, .not. all(field%pressure > not_computed))
    call plot%begin_plot(label, buffer)
    call plot%add_pixels(mean, .true., buffer)
    call plot%add_note(1, trim(blanks(quantity)), buffer, 'white')
    if (note /= '') call plot%add_note(2, note, buffer)
    if (.not. all(field%pressure > not_computed)) &
      call plot%add_note(plot%notes, 'not measured', buffer, '#a0a0a0')
    call buffer%line('</svg>')
  end subroutine draw_plan

  !> Draws the heights of a map and its summits in plan, from the centre of the first pixel on.
  subroutine draw_map(title, map, summits, buffer)
    character(len=*), intent(in) :: title       !! first line; a long one is cut
    type(height_map), intent(in) :: map         !! levelled height map
    type(map_summits), intent(in) :: summits    !! of this map
    type(text_buffer), intent(inout) :: buffer  !! gets the drawing, an SVG
    type(svg_plot) :: plot
    real(real64), allocatable :: mean(:, :)
    integer, allocatable :: order(:)
    real(real64) :: middle, deviation
    character(len=:), allocatable :: note, text
    integer :: i, number

    plot%title = title
    call average_squares(map%height, width_of_file, mean, note)
    call set_axes(plot, [0.0_real64, 0.0_real64], map%pixel_spacing, [map%columns, map%rows], &
                  map%unit)
    associate (is_known => mean > not_computed)
      middle = sum(mean, is_known) / count(is_known)
      deviation = sqrt(sum((mean - middle)**2, is_known) / count(is_known))
      plot%axes(3) = plot_axis('height', map%unit, &
        max(middle - most_deviations * deviation, minval(mean, is_known)), &
        min(middle + most_deviations * deviation, maxval(mean, is_known)))
    end associate
    plot%notes = 1 + merge(1, 0, note /= '') + merge(0, 1, all(is_measured(map%height)))
    call plot%begin_plot(title, buffer)
    call plot%add_pixels(mean, .false., buffer)
    number = size(summits%x)
    order = [(i, i=1, number)]
    if (number > most_dots) then
      call sort_keys(summits%height, order)
      order = order(number - most_dots + 1:)
    end if
    call plot%add_marks(summits%x(order), summits%y(order), merge(2, 4, number > many_dots), buffer)
    text = count_text(number, 'summit') // ' (dots)'
    if (number > most_dots) text = text // ', the highest ' // decimal_text(most_dots) // ' drawn'
    call plot%add_note(1, text, buffer)
    if (note /= '') call plot%add_note(2, note, buffer)
    if (.not. all(is_measured(map%height))) &
      call plot%add_note(plot%notes, 'not measured', buffer, '#a0a0a0')
    call buffer%line('</svg>')
  end subroutine draw_map

  ! The axes of a plan of pixels, and its size.
  subroutine set_axes(plot, first, sides, pixels, unit)
    type(svg_plot), intent(inout) :: plot
    real(real64), intent(in) :: first(2), sides(2)  ! centre of the first pixel, sides of pixels
    integer, intent(in) :: pixels(2)
    character(len=*), intent(in) :: unit

    plot%axes(:2)%name = ['x', 'y']
    plot%axes(:2)%unit = unit
    plot%axes(:2)%low = first - 0.5_real64 * sides
    plot%axes(:2)%high = first + (pixels - 0.5_real64) * sides
    plot%has_colours = .true.
    plot%longest = merge(width_of_file, side_of_plan, allocated(plot%title))
  end subroutine set_axes

  ! Mean values of squares of measured pixels, with a note on them; `not_computed` where none was
  ! measured.
  pure subroutine average_squares(values, most_pixels, mean, note)
    real(real64), intent(in) :: values(:, :)
    integer, intent(in) :: most_pixels
    real(real64), allocatable, intent(out) :: mean(:, :)
    character(len=:), allocatable, intent(out) :: note
    integer :: i, j, step

    note = ''
    step = (maxval(shape(values)) + most_pixels - 1) / most_pixels
    allocate (mean((size(values, 1) + step - 1) / step, (size(values, 2) + step - 1) / step), &
              source=not_computed)
    do j = 1, size(mean, 2)
      do i = 1, size(mean, 1)
        associate (square => values((i - 1) * step + 1:min(i * step, size(values, 1)), &
                                    (j - 1) * step + 1:min(j * step, size(values, 2))))
          if (any(is_measured(square))) &
            mean(i, j) = sum(square, is_measured(square)) / count(is_measured(square))
        end associate
      end do
    end do
    if (step > 1) note = 'colours: means of ' // decimal_text(step) // ' x ' // &
                         decimal_text(step) // ' pixels; greatest pixel ' // &
                         number_text(maxval(values, is_measured(values)), digits_of_pixel)
  end subroutine average_squares

end module asperity_field_picture
