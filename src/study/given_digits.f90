!> What the digits of the input mean: heights and radii are known to half a unit of the last digit
!> that any of them was given with.
module asperity_given_digits
  use asperity_decimal, only: decimal_value
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: int64, real64
  use asperity_number_span, only: number_span, span_of
  use asperity_random_philox, only: philox_block
  use asperity_scene_values, only: scene, scene_surface
  implicit none
  private

  public :: half_units, perturbed_scene

  ! So many numbers are looked at, spread over all.
  integer, parameter :: most_looked_at = 2000
  ! A deck has inches.
  real(real64), parameter :: cm_per_inch = 2.54_real64

contains

  !> Half a unit of the last digit that any number of both surfaces has: of the heights, of the
  !> radii. A whole number that all are is taken as exact. Of a map its samples'; of two the larger.
  pure function half_units(scene_in) result(halves)
    type(scene), intent(in) :: scene_in  !! checked values
    real(real64) :: halves(2)

    if (allocated(scene_in%map)) then
      halves = [0.5_real64 * max(scene_in%map%upper%digit, scene_in%map%lower%digit), 0.0_real64]
    else if (allocated(scene_in%deck) .and. scene_in%from_deck) then
      associate (upper => scene_in%deck%upper, lower => scene_in%deck%lower)
        halves(1) = cm_per_inch * unit_of([upper%z, lower%z]) / 2
        halves(2) = cm_per_inch * unit_of([upper%radius, lower%radius]) / 2
      end associate
    else
      halves(1) = unit_of_doubles([scene_in%upper%height, scene_in%lower%height]) / 2
      halves(2) = unit_of_doubles([scene_in%upper%radius, scene_in%lower%radius]) / 2
    end if
  end function half_units

  ! The unit of the last digit of decimals as they were written.
  pure real(real64) function unit_of(values)
    type(decimal_value), intent(in) :: values(:)

    unit_of = 0.0_real64
    if (any(values%digits /= 0_int64)) &
      unit_of = 10.0_real64**minval(values%exponent, values%digits /= 0_int64)
  end function unit_of

  ! Of doubles: of the shortest decimals that give them back.
  pure real(real64) function unit_of_doubles(values) result(unit)
    real(real64), intent(in) :: values(:)
    integer :: i, last, power

    last = huge(last)
    do i = 1, size(values), 1 + size(values) / most_looked_at
      if (.not. abs(values(i)) > 0.0_real64) cycle
      call shortest(values(i), power)
      last = min(last, power)
    end do
    unit = 0.0_real64
    if (last >= 0 .and. .not. maxval(values) > minval(values)) return
    if (last < huge(last)) unit = 10.0_real64**last
  end function unit_of_doubles

  ! The power of ten of the last digit of the shortest decimal that gives a double back.
  pure subroutine shortest(value, power)
    real(real64), intent(in) :: value
    integer, intent(out) :: power
    character(len=32) :: form, text
    real(real64) :: back
    integer :: digits, status

    do digits = 1, 17
      write (form, '("(es32.", i0, "e4)")') digits - 1
      write (text, form) value
      read (text, *, iostat=status) back
      if (status /= 0) cycle
      if (.not. abs(back - value) > 0.0_real64) exit
    end do
    read (text(index(text, 'E') + 1:), *) power
    power = power - (min(digits, 17) - 1)
  end subroutine shortest

  !> A scene whose heights and radii are other numbers that would have been written as these, drawn
  !> evenly. Radii that are all equal move together.
  subroutine perturbed_scene(scene_in, halves, draw, copy)
    type(scene), intent(in) :: scene_in      !! checked values
    real(real64), intent(in) :: halves(2)    !! as `half_units` has them; of a map it has its own
    integer, intent(in) :: draw              !! number of the draw, from 1
    type(scene), intent(out) :: copy         !! the other scene

    copy = scene_in
    if (allocated(copy%map)) then
      call move_samples(copy%map%upper, 1)
      call move_samples(copy%map%lower, 2)
    else
      call move(copy%upper, 1)
      call move(copy%lower, 2)
    end if

  contains

    subroutine move(surface, side)
      type(scene_surface), intent(inout) :: surface
      integer, intent(in) :: side
      type(number_span) :: span
      integer :: i
      logical :: alike

      if (surface%is_plane) return
      if (allocated(surface%exact_height)) deallocate (surface%exact_height)
      if (allocated(surface%exact_radius)) deallocate (surface%exact_radius)
      span = span_of(surface%radius)
      alike = .not. span%largest > span%least
      do i = 1, size(surface%height)
        surface%height(i) = surface%height(i) + halves(1) * even(i, side, 1)
        surface%radius(i) = surface%radius(i) + halves(2) * even(merge(1, i, alike), side, 2)
      end do
      surface%radius = max(surface%radius, 0.5_real64 * span%least)
    end subroutine move

    subroutine move_samples(map, side)
      type(height_map), intent(inout) :: map
      integer, intent(in) :: side
      integer :: i, j

      do j = 1, map%rows
        do i = 1, map%columns
          if (is_measured(map%height(i, j))) map%height(i, j) = map%height(i, j) + &
            0.5_real64 * map%digit * even(i, side, 2 + j)
        end do
      end do
    end subroutine move_samples

    ! From -1 to 1.
    real(real64) function even(i, side, what)
      integer, intent(in) :: i, side, what
      integer(int64) :: words(4)

      words = philox_block([int(i, int64), int(side, int64), int(what, int64), 0_int64], &
                           [int(draw, int64), 0_int64])
      even = real(words(1), real64) / 2.0_real64**31 - 1.0_real64
    end function even

  end subroutine perturbed_scene

end module asperity_given_digits
