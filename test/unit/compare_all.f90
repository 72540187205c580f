!> All asperities compared with all.
module asperity_compare_all
  use asperity_all_pairs, only: all_pairs
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_sphere_overlap, only: touching_height
  use asperity_kinds, only: real64
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: compare_all

contains

  !> Finds every pair of a position whose spheres can touch.
  subroutine compare_all(scene_in, m, power, truth)
    type(scene), intent(in) :: scene_in  !! not turned, tilted or mirrored
    integer, intent(in) :: m             !! position, from 1
    integer, intent(in) :: power         !! the unit of length is 16**power
    type(all_pairs), intent(out) :: truth  !! in doubles
    real(real64) :: dx, dy, across, along, s, d, zc, first_touch
    real(real64), allocatable :: touch(:, :)
    real(real64), dimension(size(scene_in%upper%x)) :: xu, yu, hu, ru
    real(real64), dimension(size(scene_in%lower%x)) :: xl, yl, hl, rl
    integer :: i, k

    dx = length(scene_in%motion%x_first) + (m - 1) * length(scene_in%motion%x_step)
    dy = length(scene_in%motion%y_first) + (m - 1) * length(scene_in%motion%y_step)
    xu = scale(scene_in%upper%x, -4 * power)
    yu = scale(scene_in%upper%y, -4 * power)
    hu = scale(scene_in%upper%height, -4 * power)
    ru = scale(scene_in%upper%radius, -4 * power)
    xl = scale(scene_in%lower%x, -4 * power)
    yl = scale(scene_in%lower%y, -4 * power)
    hl = scale(scene_in%lower%height, -4 * power)
    rl = scale(scene_in%lower%radius, -4 * power)
    i = size(xu)
    k = size(xl)
    allocate (touch(i, k), truth%can_touch(i, k), truth%gap(i, k), truth%d(i, k), truth%s(i, k), &
              truth%zc(i, k), truth%radius(i, k))
    truth%can_touch = .false.
    do i = 1, size(xu)
      do k = 1, size(xl)
        across = (xu(i) + dx) - xl(k)
        along = (yu(i) + dy) - yl(k)
        s = ru(i) + rl(k)
        ! Squares of farther ones would overflow.
        if (across >= s .or. across <= -s .or. along >= s .or. along <= -s) cycle
        d = sqrt(across * across + along * along)
        if (d >= s) cycle
        zc = sqrt((s - d) * (s + d))
        touch(i, k) = (hu(i) + hl(k)) - (across * across + along * along) / (s + zc)
        if (any(truth%can_touch)) then
          if (touch(i, k) > first_touch) first_touch = touch(i, k)
        else
          first_touch = touch(i, k)
        end if
        truth%can_touch(i, k) = .true.
        truth%d(i, k) = d
        truth%s(i, k) = s
        truth%radius(i, k) = ru(i) * rl(k) / s
        call touching_height(s, d, zc, along)
        truth%zc(i, k) = zc
      end do
    end do
    truth%gap = huge(1.0_real64)
    if (.not. any(truth%can_touch)) return
    where (truth%can_touch) truth%gap = first_touch - touch
    truth%first_touch = first_touch
    truth%compression = first_touch - length(scene_in%loading%value)

  contains

    function length(value)
      type(decimal_value), intent(in) :: value
      real(real64) :: length

      length = scale(decimal_to_real64(value), -4 * power)
    end function length

  end subroutine compare_all
end module asperity_compare_all
