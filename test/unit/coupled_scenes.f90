!> Contacts of paraboloids on one half-space whose loads are known, for the tests of interaction.
!>
!> Truths: loads of two to four paraboloids from a boundary-element solve in numpy (Love's cells,
!> non-negative pressure by Polonsky and Keer, 40 cells a radius, the fifth digit steady).
module asperity_coupled_scenes
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_contacts, only: coupled_solution, solve_coupled
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: known_scene, known_scenes, random, lay_contacts, share_of, solve_at

  !> Penetration of a contact alone, so small that the sphere is a paraboloid.
  real(real64), parameter, public :: depth = 1.0e-12_real64
  !> How good the truths are: a contact that carries alone, 8/9 of the load, they put at .88886.
  real(real64), parameter, public :: truth_noise = 4.0e-5_real64

  !> Up to five contacts and the share of the load that they carry together.
  type :: known_scene
    character(24) :: name = ''                                  !! what it is
    integer :: contacts = 2                                     !! how many
    real(real64) :: x(5) = 0.0_real64, y(5) = 0.0_real64        !! in circles of one at full depth
    real(real64) :: gap(5) = 0.0_real64                         !! in depths
    real(real64) :: radius(5) = 1.0_real64                      !! of the spheres together
    real(real64) :: truth = 1.0_real64                          !! load together over load alone
    logical :: overlapping = .false.                            !! the circles do
    type(contact_pairs) :: pairs                                !! its contacts
    type(hertz_law) :: law                                      !! of all
  end type known_scene

contains

  !> Spheres of radius 1 unless reported, places in units of the circle of a contact at full depth,
  !> gaps in units of the depth. Modulus 2.
  pure subroutine lay_contacts(x, y, gap, pairs, law, radius)
    real(real64), intent(in) :: x(:), y(:), gap(:)          !! by contact
    type(contact_pairs), intent(out) :: pairs               !! in the order of the gaps as given
    type(hertz_law), intent(out) :: law                     !! of all
    real(real64), intent(in), optional :: radius(:)         !! by contact
    integer :: i

    law%modulus = 2.0_real64
    pairs%modulus = law%modulus
    allocate (pairs%list(size(x)))
    do i = 1, size(x)
      associate (pair => pairs%list(i))
        pair%x = x(i) * sqrt(depth)
        pair%y = y(i) * sqrt(depth)
        pair%gap = gap(i) * depth
        pair%radius = 1.0_real64
        if (present(radius)) pair%radius = radius(i)
        pair%upper_radius = 2 * pair%radius
        pair%lower_radius = 2 * pair%radius
        pair%upper_x = pair%x
        pair%upper_y = pair%y
        pair%lower_x = pair%x
        pair%lower_y = pair%y
        pair%s = 4 * pair%radius
        pair%zc = pair%s
      end associate
    end do
  end subroutine lay_contacts

  !> Solves the circles at a compression of one depth.
  subroutine solve_at(pairs, law, solution)
    type(contact_pairs), intent(in) :: pairs                !! the contacts
    type(hertz_law), intent(in) :: law                      !! of all
    type(coupled_solution), intent(out) :: solution         !! at the depth

    solution%compression = depth
    call solve_coupled(pairs, law, solution)
  end subroutine solve_at

  !> Load together over the loads alone, at a compression of one depth.
  real(real64) function share_of(pairs, solution) result(share)
    type(contact_pairs), intent(in) :: pairs                !! the contacts
    type(coupled_solution), intent(in) :: solution          !! solved

    share = sum(solution%set%load) / (4.0_real64 / 3.0_real64 * &
            sum(sqrt(pairs%list%radius) * max(0.0_real64, depth - pairs%list%gap)**1.5_real64))
  end function share_of

  !> The scenes whose truth is known.
  function known_scenes() result(scenes)
    type(known_scene) :: scenes(18)
    real(real64), parameter :: distances(9) = [0.8_real64, 1.2_real64, 1.5_real64, 1.7_real64, &
      2.0_real64, 2.3_real64, 3.0_real64, 4.0_real64, 10.0_real64]
    real(real64), parameter :: shares(9) = [0.63423_real64, 0.68788_real64, 0.72194_real64, &
      0.74183_real64, 0.76779_real64, 0.78966_real64, 0.82844_real64, 0.86472_real64, &
      0.94060_real64]
    real(real64), parameter :: o = 0.0_real64, two = 2.0_real64, three = 3.0_real64
    real(real64), parameter :: near = 1.7_real64, high = 0.75_real64**0.5_real64
    integer :: i

    do i = 1, 9
      write (scenes(i)%name, '(a, f5.1)') 'two at', distances(i)
      scenes(i)%x(2) = distances(i)
      scenes(i)%truth = shares(i)
      scenes(i)%overlapping = distances(i) < two
    end do
    call put(scenes(10), 'triangle, 2', [o, two, two / 2], [o, o, two * high], 0.63307_real64)
    call put(scenes(11), 'triangle, 3', [o, three, three / 2], [o, o, three * high], &
             0.71338_real64)
    call put(scenes(12), 'square, 2', [o, two, o, two], [o, o, two, two], 0.56320_real64)
    call put(scenes(13), 'square, 1.7', [o, near, o, near], [o, o, near, near], 0.52868_real64)
    call put(scenes(14), 'row, 2', two * [0, 1, 2, 3, 4], [o, o, o, o, o], 0.57449_real64)
    call put(scenes(15), 'a shallow one, 2', [o, two], [o, o], 0.89341_real64)
    call put(scenes(16), 'a shallow one that opens', [o, 1.3_real64], [o, o], 0.88886_real64)
    scenes(15:16)%gap(2) = 0.75_real64
    call put(scenes(17), 'a small sphere, 2', [o, two], [o, o], 0.83274_real64)
    call put(scenes(18), 'a small sphere, 1.2', [o, 1.2_real64], [o, o], 0.76251_real64)
    scenes(17:18)%radius(2) = 0.25_real64
    scenes(13)%overlapping = .true.
    scenes(18)%overlapping = .true.
    do i = 1, size(scenes)
      associate (scene => scenes(i), n => scenes(i)%contacts)
        call lay_contacts(scene%x(:n), scene%y(:n), scene%gap(:n), scene%pairs, scene%law, &
                          scene%radius(:n))
      end associate
    end do

  contains

    subroutine put(scene, name, x, y, truth)
      type(known_scene), intent(inout) :: scene
      character(*), intent(in) :: name
      real(real64), intent(in) :: x(:), y(:), truth

      scene%name = name
      scene%contacts = size(x)
      scene%x(:size(x)) = x
      scene%y(:size(y)) = y
      scene%truth = truth
    end subroutine put

  end function known_scenes

  !> A number from 0 to 1 (Marsaglia's xorshift).
  function random(seed) result(number)
    integer(int64), intent(inout) :: seed                   !! not 0; changes
    real(real64) :: number

    seed = ieor(seed, shiftl(seed, 13))
    seed = ieor(seed, shiftr(seed, 7))
    seed = ieor(seed, shiftl(seed, 17))
    number = shiftr(seed, 11) * 2.0_real64**(-53)
  end function random

end module asperity_coupled_scenes
