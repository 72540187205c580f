!> Shifts of circles beside larger ones: around them, not straight on.
!>
!> A contact beside a larger one, such as that of a blunt cap under a sharp one with the same axis,
!> lies in a ring-shaped valley of the potential. A straight step leaves it soon, and many short
!> ones would have to go around. So what such a shift does across the line from the larger circle is
!> an angle around it. Places and shifts are complex numbers here.
module asperity_coupled_turns
  use asperity_circle_field, only: are_close, circle_set, from_other, many
  use asperity_kinds, only: real64
  implicit none
  private

  public :: find_large, length_of, turn_shift

  ! Sums of radii up to which a circle is beside another.
  real(real64), parameter :: close_by = 2.0_real64
  ! Angle of a step at most.
  real(real64), parameter :: most_turned = 0.5_real64

contains

  !> Where each circle stands from the larger one beside it; 0 where there is none or more than one.
  function find_large(set) result(from)
    type(circle_set), intent(in) :: set          !! planted; shifts are set
    complex(real64) :: from(size(set%x))
    real(real64) :: way(2)
    integer :: found, k, l

    from = 0.0_real64
    !$omp parallel do schedule(static) private(found, l, way) if(size(set%x) > many)
    do k = 1, size(set%x)
      found = 0
      do l = set%tree%first(k), set%tree%first(k + 1) - 1
        associate (j => set%tree%near(l))
          if (set%circle(j) < set%circle(k)) cycle
          if (.not. are_close(set, k, j, close_by)) cycle
          found = found + 1
          way = from_other(set, k, j)
          from(k) = cmplx(way(1), way(2), real64)
        end associate
      end do
      if (found > 1) from(k) = 0.0_real64
    end do
    !$omp end parallel do
  end function find_large

  !> Length of a shift over the longest one that may be gone: the own circle, or around the large
  !> one by an angle, if that is farther.
  elemental real(real64) function length_of(shift, from, circle) result(length)
    complex(real64), intent(in) :: shift         !! a step
    complex(real64), intent(in) :: from          !! place from the large circle, or 0
    real(real64), intent(in) :: circle           !! the own radius
    complex(real64) :: along

    length = abs(shift) / circle
    if (.not. abs(from) > 0.0_real64) return
    along = shift * conjg(from / abs(from))
    length = max(abs(along%re) / circle, abs(along%im) / max(circle, most_turned * abs(from)))
  end function length_of

  !> Where a share of a shift leads to, and where the shift points to there.
  elemental subroutine turn_shift(share, shift, from, to, direction)
    real(real64), intent(in) :: share            !! 1 at most
    complex(real64), intent(in) :: shift         !! a step
    complex(real64), intent(in) :: from          !! place from the large circle, or 0
    complex(real64), intent(out) :: to           !! from where it was
    complex(real64), intent(out) :: direction    !! as long as the whole shift
    complex(real64) :: along, way

    to = share * shift
    direction = shift
    if (.not. abs(from) > 0.0_real64) return
    along = shift * conjg(from / abs(from))
    way = from / abs(from) * exp(cmplx(0.0_real64, share * along%im / abs(from), real64))
    to = (abs(from) + share * along%re) * way - from
    direction = along * way
  end subroutine turn_shift

end module asperity_coupled_turns
