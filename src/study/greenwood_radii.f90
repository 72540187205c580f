!> Means over the radii of two surfaces that the contact integrals need.
module asperity_greenwood_radii
  use asperity_generation_values, only: exact_value, gaussian_spec
  use asperity_gauss_rule, only: gauss_rule
  use asperity_kinds, only: real128
  implicit none
  private

  public :: radius_means, means_over_radii

  !> Means over pairs of radii r1 and r2, with s = r1 + r2 and R = r1 r2/s.
  type :: radius_means
    real(real128) :: sum = 0.0_real128            !! of s
    real(real128) :: product = 0.0_real128        !! of R s
    real(real128) :: combined = 0.0_real128       !! of R
    real(real128) :: root = 0.0_real128           !! of sqrt(R)
    real(real128) :: root_sum = 0.0_real128       !! of sqrt(R) s
    real(real128) :: upper = 0.0_real128          !! of r1
    real(real128) :: root_upper = 0.0_real128     !! of sqrt(r1)
  end type radius_means

  integer, parameter :: points = 16

contains

  !> The means for two laws of the radius.
  pure subroutine means_over_radii(radii, means)
    type(gaussian_spec), intent(in) :: radii(2)  !! upper and lower surface
    type(radius_means), intent(out) :: means     !! of all pairs
    real(real128), allocatable :: upper(:), lower(:), upper_weights(:), lower_weights(:)
    real(real128) :: weight, s, combined
    integer :: i, j

    call places_and_weights(radii(1), upper, upper_weights)
    call places_and_weights(radii(2), lower, lower_weights)
    do i = 1, size(upper)
      means%upper = means%upper + upper_weights(i) * upper(i)
      means%root_upper = means%root_upper + upper_weights(i) * sqrt(upper(i))
      do j = 1, size(lower)
        weight = upper_weights(i) * lower_weights(j)
        s = upper(i) + lower(j)
        combined = upper(i) * lower(j) / s
        means%sum = means%sum + weight * s
        means%product = means%product + weight * upper(i) * lower(j)
        means%combined = means%combined + weight * combined
        means%root = means%root + weight * sqrt(combined)
        means%root_sum = means%root_sum + weight * sqrt(combined) * s
      end do
    end do
  end subroutine means_over_radii

  !> Places of a law and their weights, whose sum is 1. Gauss's rule on pieces of at most a
  !> deviation, in the root of the radius.
  pure subroutine places_and_weights(radius, places, weights)
    type(gaussian_spec), intent(in) :: radius
    real(real128), allocatable, intent(out) :: places(:), weights(:)
    real(real128) :: nodes(points), rule(points), mean, deviation, from, step, root
    integer :: pieces, i, k

    if (.not. radius%highest > radius%lowest) then
      allocate (places(1), weights(1))
      places = radius%lowest
      weights = 1.0_real128
      return
    end if
    mean = exact_value(radius%mean)
    deviation = exact_value(radius%deviation)
    pieces = max(2, ceiling((radius%highest - radius%lowest) / deviation))
    allocate (places(pieces * points), weights(pieces * points))
    call gauss_rule(nodes, rule)
    step = (sqrt(radius%highest) - sqrt(radius%lowest)) / pieces
    do i = 1, pieces
      from = sqrt(radius%lowest) + (i - 1) * step
      do k = 1, points
        root = from + step * (1 + nodes(k)) / 2
        places((i - 1) * points + k) = root**2
        weights((i - 1) * points + k) = rule(k) * root * &
                                        exp(-((root**2 - mean) / deviation)**2 / 2)
      end do
    end do
    weights = weights / sum(weights)
  end subroutine places_and_weights

end module asperity_greenwood_radii
