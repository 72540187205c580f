!> Gap and displacement of a height map that is in contact: as fields, and as numbers of its state.
module asperity_map_fields
  use asperity_contact_field, only: contact_field
  use asperity_contact_records, only: state_row
  use asperity_height_map, only: height_map, index_beside, is_measured, no_height
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_map_contact, only: map_answer
  implicit none
  private

  public :: measure_fields, take_field

contains

  !> Computes mean gap, root mean square of the gap, perimeter and elastic energy of a state.
  !>
  !> Gaps are averaged over the measured pixels. The perimeter is the length of all sides between a
  !> pixel in contact and a measured pixel out of contact: of a smooth rim it is 4/pi times the
  !> length in the mean over all directions. The energy is half the sum of pressure times
  !> displacement times the area of a pixel; a periodic map has that of one period, without the
  !> uniform compression of the half-space.
  pure subroutine measure_fields(map, answer, state)
    type(height_map), intent(in) :: map          !! at least one pixel measured
    type(map_answer), intent(in) :: answer       !! of this map, with its displacement
    type(state_row), intent(inout) :: state      !! gets the four numbers
    logical :: touches(map%columns, map%rows)
    real(real64) :: energy, gap, perimeter, squares, total
    integer(int64) :: measured
    integer :: above, beside, i, j

    touches = touching_pixels(answer)
    measured = 0_int64
    total = 0.0_real64
    squares = 0.0_real64
    energy = 0.0_real64
    perimeter = 0.0_real64
    do j = 1, map%rows
      above = index_beside(j + 1, map%rows, map%repeats(2))
      beside = index_beside(map%columns + 1, map%columns, map%repeats(1))
      do i = 1, map%columns
        if (.not. map%height(i, j) > 0.5_real64 * no_height) cycle
        gap = local_gap(map%height(i, j), answer%displacement(i, j), touches(i, j), answer%level)
        measured = measured + 1_int64
        total = total + gap
        squares = squares + gap**2
        energy = energy + answer%pressure(i, j) * answer%displacement(i, j)
        if (is_rim(i, j, merge(i + 1, beside, i < map%columns), j)) &
          perimeter = perimeter + map%pixel_spacing(2)
        if (is_rim(i, j, i, above)) perimeter = perimeter + map%pixel_spacing(1)
      end do
    end do
    state%mean_gap = total / measured
    state%rms_gap = sqrt(squares / measured)
    state%contact_perimeter = perimeter
    state%elastic_energy = 0.5_real64 * energy * product(map%pixel_spacing)

  contains

    ! Whether a measured pixel and one beside it are divided by the rim of a patch.
    pure logical function is_rim(i, j, beside, above)
      integer, intent(in) :: i, j
      integer, intent(in) :: beside, above  ! 0: beyond the edge of a free map

      is_rim = .false.
      if (beside == 0 .or. above == 0) return
      is_rim = touches(i, j) .neqv. touches(beside, above)
      if (is_rim) is_rim = is_measured(map%height(beside, above))
    end function is_rim

  end subroutine measure_fields

  !> Fills the fields of a state.
  pure subroutine take_field(map, answer, number, field)
    type(height_map), intent(in) :: map        !! that was solved
    type(map_answer), intent(in) :: answer     !! of this map, with its displacement
    integer, intent(in) :: number              !! of the state
    type(contact_field), intent(inout) :: field  !! its unit is set

    field%state = number
    field%columns = map%columns
    field%rows = map%rows
    field%periodic = map%periodic
    field%strip_axis = map%strip_axis
    field%pixel_spacing = map%pixel_spacing
    field%level = answer%level
    field%pressure = merge(answer%pressure, not_computed, is_measured(map%height))
    field%displacement = merge(answer%displacement, not_computed, is_measured(map%height))
    field%gap = field%pressure
    where (is_measured(map%height)) field%gap = local_gap( &
      map%height, answer%displacement, touching_pixels(answer), answer%level)
  end subroutine take_field

  ! Whether each pixel is in contact.
  pure function touching_pixels(answer) result(touches)
    type(map_answer), intent(in) :: answer
    logical :: touches(size(answer%pressure, 1), size(answer%pressure, 2))

    touches = answer%pressure > 0.0_real64
    if (allocated(answer%touches)) touches = answer%touches
  end function touching_pixels

  ! Gap of the deformed surfaces. The solver leaves at most its tolerance of it in contact, and at
  ! most that below 0: both are set to 0.
  elemental real(real64) function local_gap(height, displacement, is_closed, level) result(gap)
    real(real64), intent(in) :: height, displacement, level
    logical, intent(in) :: is_closed

    gap = 0.0_real64
    if (.not. is_closed) gap = max(0.0_real64, (level - height) + displacement)
  end function local_gap

end module asperity_map_fields
