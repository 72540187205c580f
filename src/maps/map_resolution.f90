!> A height map on fewer or more pixels.
module asperity_map_resolution
  use asperity_height_map, only: height_map, is_measured, no_height
  use asperity_kinds, only: int64, real64
  use asperity_plane_transform, only: plane_transform
  implicit none
  private

  public :: doubled_map, every_pixel, refine_waves, take_heights

  ! Largest rms height of the waves below three pixels over that of the map, with which the map is
  ! the sum of its waves between the pixels (chosen: below the errors of all pixels; a spectrum that
  ! goes on as q**(-2 (1 + H)) has at most twice as much beyond two pixels for H from 0.3 on).
  real(real64), parameter :: unseen_share = 1.0e-6_real64

contains

  !> The map on every second pixel or fewer. A periodic map keeps its lengths: where the step does
  !> not divide its number of pixels, they are a little narrower.
  pure type(height_map) function every_pixel(map, step) result(coarse)
    type(height_map), intent(in) :: map       !! map of any size
    integer, intent(in) :: step               !! pixels along both sides to the next one

    call take_heights(map, real([step, step], real64), map%height(::step, ::step), coarse)
  end function every_pixel

  !> The map on pixels half as wide along both sides: between two pixels the cubic through the four
  !> nearest, the line where one of the outer two is missing.
  pure type(height_map) function doubled_map(map) result(fine)
    type(height_map), intent(in) :: map  !! map of any size

    call take_heights(map, [0.5_real64, 0.5_real64], doubled_lines(transpose(doubled_lines( &
      transpose(map%height), map%repeats(2))), map%repeats(1)), fine)
  end function doubled_map

  !> The map on other pixels, as the sum of its waves, which is exact for a surface without waves
  !> below two pixels (C. E. Shannon, Proc. IRE 37 (1949) 10).
  subroutine refine_waves(map, resolution, fine, is_known)
    type(height_map), intent(in) :: map        !! map of any size
    real(real64), intent(in) :: resolution     !! least pixels along a side over those of the map,
                                               !! more than 2/3
    type(height_map), intent(out) :: fine      !! the map on these pixels, where it is known
    !> The map repeats itself along both sides, and has all heights and no waves below three pixels.
    logical, intent(out) :: is_known
    type(plane_transform) :: coarse, refined
    complex(real64), allocatable :: waves(:, :), same(:, :)
    real(real64), allocatable :: height(:, :)
    integer :: i, m(2), n(2)

    n = shape(map%height)
    m = [(quick_number(resolution * n(i)), i=1, 2)]
    is_known = map%repeats(1) .and. map%repeats(2) .and. all(n > 2) .and. &
               all(is_measured(map%height))
    if (.not. is_known) return
    allocate (waves(0:n(2) - 1, 0:n(1) / 2), same(0:m(2) - 1, 0:m(1) / 2), height(m(1), m(2)))
    call coarse%prepare(n(1), n(2))
    call coarse%make_waves(map%height, waves)
    waves(0, 0) = 0.0_real64
    same = 0.0_real64
    n = n / 3
    same(:n(2), :n(1)) = waves(:n(2), :n(1))
    same(m(2) - n(2):, :n(1)) = waves(size(waves, 1) - n(2):, :n(1))
    is_known = sum(abs(waves)**2) - sum(abs(same)**2) <= unseen_share**2 * sum(abs(same)**2)
    if (.not. is_known) return
    call refined%prepare(m(1), m(2))
    call refined%sum_waves(same, height)
    height = height * (product(real(m, real64)) / size(map%height, kind=int64)) + &
             sum(map%height) / size(map%height, kind=int64)
    call take_heights(map, shape(map%height) / real(m, real64), height, fine)
  end subroutine refine_waves

  ! The first number from one on that is quick to transform and has halves and thirds, from which
  ! errors are estimated: 6 times powers of 2, 3 and 5.
  pure integer function quick_number(least) result(number)
    real(real64), intent(in) :: least
    integer :: rest

    number = 6 * ceiling(least / 6) - 6
    rest = 0
    do while (rest /= 1)
      number = number + 6
      rest = number / 6
      do while (mod(rest, 2) == 0)
        rest = rest / 2
      end do
      do while (mod(rest, 3) == 0)
        rest = rest / 3
      end do
      do while (mod(rest, 5) == 0)
        rest = rest / 5
      end do
    end do
  end function quick_number

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
