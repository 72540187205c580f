!> A height map on fewer or more pixels.
module asperity_map_resolution
  use asperity_height_map, only: height_map, is_measured, no_height
  use asperity_kinds, only: real64
  implicit none
  private

  public :: doubled_map, every_pixel, take_heights

contains

  !> The map on every second pixel or fewer. A periodic map keeps its lengths: where the step does
  !> not divide its number of pixels, they are a little narrower.
  pure type(height_map) function every_pixel(map, step, first) result(coarse)
    type(height_map), intent(in) :: map       !! map of any size
    integer, intent(in) :: step               !! pixels along both sides to the next one
    integer, intent(in), optional :: first(2)  !! column and row of the first; absent: 1, 1
    integer :: begin(2)

    begin = 1
    if (present(first)) begin = first
    call take_heights(map, real([step, step], real64), map%height(begin(1)::step, begin(2)::step), &
                      coarse)
  end function every_pixel

  !> The map on pixels half as wide along both sides: between two pixels the cubic through the four
  !> nearest, the line where one of the outer two is missing.
  pure type(height_map) function doubled_map(map) result(fine)
    type(height_map), intent(in) :: map  !! map of any size

    call take_heights(map, [0.5_real64, 0.5_real64], doubled_lines(transpose(doubled_lines( &
      transpose(map%height), map%repeats(2))), map%repeats(1)), fine)
  end function doubled_map

  !> Makes a map with other heights. A periodic map keeps its lengths.
  pure subroutine take_heights(map, ratio, height, changed)
    type(height_map), intent(in) :: map          !! map that the heights are from
    real(real64), intent(in) :: ratio(2)         !! of its spacing to that of this map
    real(real64), intent(in) :: height(:, :)     !! heights by column and row
    type(height_map), intent(out) :: changed     !! map of these heights

    allocate (changed%height, source=height)
    changed%columns = size(height, 1)
    changed%rows = size(height, 2)
    changed%periodic = map%periodic
    changed%strip_axis = map%strip_axis
    changed%bodies = map%bodies
    changed%pixel_spacing = ratio * map%pixel_spacing
    where ([map%repeats(1), map%repeats(2)]) changed%pixel_spacing = map%pixel_spacing * &
      shape(map%height) / real(shape(height), real64)
    if (allocated(map%unit)) changed%unit = map%unit
  end subroutine take_heights

  ! Heights with one more between any two along the first index.
  pure function doubled_lines(height, periodic) result(doubled)
    real(real64), intent(in) :: height(:, :)
    logical, intent(in) :: periodic
    real(real64), allocatable :: after(:, :), before(:, :), doubled(:, :), middle(:, :), next(:, :)
    integer :: last

    next = cshift(height, 1)
    before = cshift(height, -1)
    after = cshift(height, 2)
    last = size(height, 1)
    if (.not. periodic) then
      before(1, :) = no_height
      after(max(1, last - 1):, :) = no_height
      last = last - 1
    end if
    allocate (middle, mold=height)
    where (is_measured(height) .and. is_measured(next))
      where (is_measured(before) .and. is_measured(after))
        middle = (9.0_real64 * (height + next) - (before + after)) / 16.0_real64
      else where
        middle = 0.5_real64 * (height + next)
      end where
    else where
      middle = no_height
    end where
    allocate (doubled(size(height, 1) + last, size(height, 2)))
    doubled(1::2, :) = height
    doubled(2::2, :) = middle(:last, :)
  end function doubled_lines

end module asperity_map_resolution
