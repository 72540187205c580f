!> Contact patches of a height map: pixels under pressure that share a side.
module asperity_map_patches
  use asperity_constants, only: pi
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: int64, not_computed, real64
  implicit none
  private

  public :: find_patches, map_patch

  !> One patch. Lengths from the centre of the map's first pixel, in its unit.
  type :: map_patch
    !> Centre of pressure. On a periodic map it lies from 0 to below the map's length; a patch that
    !> spans the map in a direction has no centre there: `not_computed`.
    real(real64) :: x = 0.0_real64
    real(real64) :: y = 0.0_real64                 !! likewise
    real(real64) :: load = 0.0_real64              !! on it
    real(real64) :: area = 0.0_real64              !! of its pixels, corrected at the rim
    real(real64) :: rim = 0.0_real64               !! correction by all sides of its rim
    real(real64) :: highest = 0.0_real64           !! of its pressures, mean over a sample
    real(real64) :: mean = 0.0_real64              !! load over area, at most the highest
    real(real64) :: top = -huge(1.0_real64)        !! its highest sample
    integer(int64) :: samples = 0_int64            !! how many
    integer :: across(2) = 0                       !! first and last column; beyond the end where
    integer :: along(2) = 0                        !! it goes on there; first and last row
  end type map_patch

  ! Pixels over-estimate an area by this fraction of a pixel for each side between a pressed and an
  ! open pixel, as the rim of the patch passes somewhere between their centres (Yastrebov, Anciaux
  ! and Molinari, Tribol. Int. 114 (2017) 161, eq. 2). It is a mean over smooth rims at which the
  ! pressure falls to 0. At the edge of a free map and at missing pixels the body ends: such sides
  ! are no rim. With a hardness the area of a pixel is at least its force over the hardness: nothing
  ! is taken from pixels at the hardness. Under a growing load no pixel opens and no pressure falls
  ! (Barber, Quart. J. Mech. Appl. Math. 27 (1974) 1), so that no area of a pixel falls either.
  real(real64), parameter :: rim_of_samples = (pi - 1.0_real64 + log(2.0_real64)) / 24.0_real64

  ! Pixels: above the error of a centre of pressure when gaps are closed to 1e-10 of the range of
  ! heights (chosen; test: centres in test/maps/test_map_edges.py).
  real(real64), parameter :: centre_error = 1.0e-6_real64

contains

  ! Long: the procedures of the flood fill share its stack and labels.
  !> Finds the patches, in the order of their first pixels, along x first.
  subroutine find_patches(map, pressure, patches, spot, hardness)
    type(height_map), intent(in) :: map            !! heights, and whether the map is periodic
    real(real64), intent(in) :: pressure(:, :)     !! of each pixel, 0 or more
    type(map_patch), allocatable, intent(out) :: patches(:)
    integer, allocatable, intent(out), optional :: spot(:, :)  !! patch of each pixel; 0: none
    real(real64), intent(in), optional :: hardness !! largest pressure; absent: elastic
    integer, allocatable :: label(:, :), stack(:, :)
    ! How many lengths of a periodic map lie between a pixel and where its patch was entered.
    integer, allocatable :: windings(:, :, :)
    type(map_patch), allocatable :: larger(:)
    logical :: repeats(2), spans(2)
    integer(int64) :: deep
    integer :: i, j, n  ! patches are counted in 32 bits: so many of them take 176 GiB

    allocate (label(size(pressure, 1), size(pressure, 2)), source=0)
    allocate (stack(2, count(pressure > 0.0_real64, kind=int64)), patches(16))
    repeats = [map%repeats(1), map%repeats(2)]
    if (any(repeats)) allocate (windings(2, map%columns, map%rows))
    n = 0
    do j = 1, size(pressure, 2)
      do i = 1, size(pressure, 1)
        if (label(i, j) > 0 .or. .not. pressure(i, j) > 0.0_real64) cycle
        if (n == size(patches)) then
          allocate (larger(2_int64 * n))
          larger(:n) = patches
          call move_alloc(larger, patches)
        end if
        n = n + 1
        patches(n) = map_patch(across=[i, i], along=[j, j])
        deep = 1_int64
        stack(:, 1) = [i, j]
        label(i, j) = n
        if (any(repeats)) windings(:, i, j) = 0
        spans = .false.
        do while (deep > 0)
          call take_pixel(patches(n))
        end do
        associate (patch => patches(n))
          patch%x = centre_of(1, patch%x / patch%load)
          patch%y = centre_of(2, patch%y / patch%load)
        end associate
      end do
    end do
    patches = patches(:n)
    patches%load = patches%load * product(map%pixel_spacing)
    patches%area = patches%area * product(map%pixel_spacing)
    patches%rim = patches%rim * product(map%pixel_spacing)
    patches%mean = min(patches%load / patches%area, patches%highest)
    if (present(spot)) call move_alloc(label, spot)

  contains

    ! Adds the topmost pixel of the stack to its patch and puts its neighbours on the stack. By its
    ! windings a patch that goes on beyond an end of a periodic map is in one piece. A pixel that is
    ! reached by two paths of different windings lies on a closed path around the map.
    subroutine take_pixel(patch)
      type(map_patch), intent(inout) :: patch
      integer, parameter :: step(2, 4) = reshape([0, 1, 0, -1, -1, 0, 1, 0], [2, 4])
      integer, parameter :: axis(4) = [2, 2, 1, 1]
      real(real64) :: least, rim
      integer :: k, lengths(2), next(2), place(2), unwrapped(2), winding(2)

      place = stack(:, deep)
      deep = deep - 1
      lengths = 0
      if (any(repeats)) lengths = windings(:, place(1), place(2))
      unwrapped = place + lengths * shape(pressure)
      rim = 0.0_real64
      least = 0.0_real64
      if (present(hardness)) least = pressure(place(1), place(2)) / hardness
      associate (p => pressure(place(1), place(2)))
        patch%samples = patch%samples + 1_int64
        patch%load = patch%load + p
        patch%x = patch%x + p * (unwrapped(1) - 1)
        patch%y = patch%y + p * (unwrapped(2) - 1)
        patch%highest = max(patch%highest, p)
        patch%top = max(patch%top, map%height(place(1), place(2)))
        patch%across = [min(patch%across(1), unwrapped(1)), max(patch%across(2), unwrapped(1))]
        patch%along = [min(patch%along(1), unwrapped(2)), max(patch%along(2), unwrapped(2))]
      end associate
      do k = 1, 4
        next = place + step(:, k)
        winding = lengths
        if (next(axis(k)) < 1 .or. next(axis(k)) > size(pressure, axis(k))) then
          if (.not. repeats(axis(k))) cycle
          winding = lengths + step(:, k)
          next = next - step(:, k) * shape(pressure)
        end if
        if (.not. pressure(next(1), next(2)) > 0.0_real64) then
          if (is_measured(map%height(next(1), next(2)))) rim = rim + rim_of_samples
        else if (label(next(1), next(2)) == 0) then
          deep = deep + 1
          stack(:, deep) = next
          label(next(1), next(2)) = n
          if (any(repeats)) windings(:, next(1), next(2)) = winding
        else if (any(repeats)) then
          spans = spans .or. windings(:, next(1), next(2)) /= winding
        end if
      end do
      patch%area = patch%area + max(1.0_real64 - rim, least)
      patch%rim = patch%rim + rim
    end subroutine take_pixel

    ! Length from the first pixel, of an unwrapped centre in pixels.
    pure real(real64) function centre_of(axis, centre) result(place)
      integer, intent(in) :: axis
      real(real64), intent(in) :: centre

      place = centre
      if (repeats(axis)) place = modulo(centre, real(size(pressure, axis), real64))
      ! An error must not move a centre from the begin of a periodic map to its end.
      if (repeats(axis) .and. size(pressure, axis) - place < centre_error) place = 0.0_real64
      place = place * map%pixel_spacing(axis)
      if (spans(axis)) place = not_computed
    end function centre_of

  end subroutine find_patches

end module asperity_map_patches
