!> The spots of a pressed map: samples under pressure that share a side.
module asperity_map_patches
  use asperity_constants, only: pi
  use asperity_height_map, only: height_map
  use asperity_kinds, only: real64
  implicit none
  private

  public :: find_patches, map_patch

  !> One spot. Lengths from the centre of the map's first sample, in its unit.
  type :: map_patch
    real(real64) :: x = 0.0_real64                 !! centre of its pressure
    real(real64) :: y = 0.0_real64                 !! centre of its pressure
    real(real64) :: load = 0.0_real64              !! on it
    real(real64) :: area = 0.0_real64              !! of its samples, corrected at the rim
    real(real64) :: highest = 0.0_real64           !! of its pressures, mean over a sample
    real(real64) :: top = -huge(1.0_real64)        !! its highest sample
    integer :: samples = 0                         !! how many
    integer :: across(2) = 0                       !! first and last column; beyond the end where
    integer :: along(2) = 0                        !! it goes on there; first and last row
  end type map_patch

  ! Samples over-count an area by that times the sides on its rim (Yastrebov, Anciaux and Molinari,
  ! Tribol. Int. 114 (2017) 161, eq. 2).
  real(real64), parameter :: rim_of_samples = (pi - 1.0_real64 + log(2.0_real64)) / 24.0_real64

contains

  !> Finds the spots, in the order of their first samples, along x first.
  subroutine find_patches(map, periodic, pressure, patches, spot)
    type(height_map), intent(in) :: map            !! the heights
    logical, intent(in) :: periodic                !! it repeats itself
    real(real64), intent(in) :: pressure(:, :)     !! on each
    type(map_patch), allocatable, intent(out) :: patches(:)
    integer, allocatable, intent(out), optional :: spot(:, :)  !! of every sample; 0: none
    integer, allocatable :: label(:, :), stack(:, :)
    type(map_patch), allocatable :: larger(:)
    integer :: deep, i, j, n

    allocate (label(size(pressure, 1), size(pressure, 2)), source=0)
    allocate (stack(2, count(pressure > 0.0_real64)), patches(16))
    n = 0
    do j = 1, size(pressure, 2)
      do i = 1, size(pressure, 1)
        if (label(i, j) > 0 .or. .not. pressure(i, j) > 0.0_real64) cycle
        if (n == size(patches)) then
          allocate (larger(2 * n))
          larger(:n) = patches
          call move_alloc(larger, patches)
        end if
        n = n + 1
        patches(n) = map_patch(across=[i, i], along=[j, j])
        deep = 1
        stack(:, 1) = [i, j]
        label(i, j) = n
        do while (deep > 0)
          call take(stack(1, deep), stack(2, deep), patches(n))
        end do
      end do
    end do
    patches = patches(:n)
    patches%x = patches%x / patches%load * map%spacing(1)
    patches%y = patches%y / patches%load * map%spacing(2)
    patches%load = patches%load * product(map%spacing)
    patches%area = patches%area * product(map%spacing)
    if (present(spot)) call move_alloc(label, spot)

  contains

    ! The topmost sample of the stack goes to its spot, its neighbours on the stack. Places are
    ! those by which a spot was reached: one that goes on beyond an end of a periodic map is whole.
    subroutine take(across, along, patch)
      integer, value :: across, along
      type(map_patch), intent(inout) :: patch
      integer, parameter :: step(2, 4) = reshape([1, 0, -1, 0, 0, 1, 0, -1], [2, 4])
      integer :: k, next(2), place(2), sides

      deep = deep - 1
      place = home(across, along)
      associate (p => pressure(place(1), place(2)))
        patch%samples = patch%samples + 1
        patch%load = patch%load + p
        patch%x = patch%x + p * (across - 1)
        patch%y = patch%y + p * (along - 1)
        patch%highest = max(patch%highest, p)
        patch%top = max(patch%top, map%height(place(1), place(2)))
        patch%across = [min(patch%across(1), across), max(patch%across(2), across)]
        patch%along = [min(patch%along(1), along), max(patch%along(2), along)]
      end associate
      sides = 0
      do k = 1, 4
        next = home(across + step(1, k), along + step(2, k))
        if (any(next < 1 .or. next > shape(pressure))) then
          sides = sides + 1
        else if (.not. pressure(next(1), next(2)) > 0.0_real64) then
          sides = sides + 1
        else if (label(next(1), next(2)) == 0) then
          deep = deep + 1
          stack(:, deep) = [across, along] + step(:, k)
          label(next(1), next(2)) = n
        end if
      end do
      patch%area = patch%area + (1.0_real64 - rim_of_samples * sides)
    end subroutine take

    pure function home(across, along) result(place)
      integer, intent(in) :: across, along
      integer :: place(2)

      place = [across, along]
      if (periodic) place = 1 + modulo(place - 1, shape(pressure))
    end function home

  end subroutine find_patches

end module asperity_map_patches
