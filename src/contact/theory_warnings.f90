!> What is computed but lies outside a theory, or is not what a user would take it for: values that
!> travel with the results of a position and are told at the edge of the program.
!>
!> docs/warnings.md has the source of every limit.
module asperity_theory_warnings
  use asperity_kinds, only: real64
  implicit none
  private

  public :: theory_warning, warning_kind, warning_kinds, warn, take_worse
  public :: of_contact_radius, of_cap, of_slope, of_yield, of_overlapping, of_crowding, of_tabor, &
            of_creep_strain, of_relaxing, of_together, of_load_direction, of_map_edge, &
            of_no_summit, of_scan_lines, of_spikes, of_area, of_flat_map, of_off, of_barred, &
            of_error

  !> Contact radius over the radius of the smaller sphere.
  integer, parameter :: of_contact_radius = 1
  !> How far a contact reaches beyond its cap, over the radius of the sphere.
  integer, parameter :: of_cap = 2
  !> Slope of a contact.
  integer, parameter :: of_slope = 3
  !> Average pressure over that at which the scene's material yields, with plasticity off.
  integer, parameter :: of_yield = 4
  !> Pairs of contact circles that overlap, with interaction off.
  integer, parameter :: of_overlapping = 5
  !> Share of the nominal area that contacts cover, with interaction off.
  integer, parameter :: of_crowding = 6
  !> Tabor parameter of a contact that adheres by the law for small ones.
  integer, parameter :: of_tabor = 7
  !> Strain in a contact that creeps.
  integer, parameter :: of_creep_strain = 8
  !> What relaxation has left to do at the end of a hold.
  integer, parameter :: of_relaxing = 9
  !> Estimated share of an effect that has no common theory with another one.
  integer, parameter :: of_together = 10

  !> Difference of the sum of the normal forces and the vertical load.
  integer, parameter :: of_load_direction = 11

  !> Share of the load of a map on its edge.
  integer, parameter :: of_map_edge = 12
  !> Share of the load of a map on spots without a summit.
  integer, parameter :: of_no_summit = 13
  !> Share of the load of a map on single scan lines.
  integer, parameter :: of_scan_lines = 14
  !> Share of the load of a map on outliers.
  integer, parameter :: of_spikes = 15
  !> What interaction says that areas may be off by, where that is more than the tolerance.
  integer, parameter :: of_area = 16
  !> A map whose heights differ by rounding alone.
  integer, parameter :: of_flat_map = 17
  !> Estimated influence on the load of an effect that is off.
  integer, parameter :: of_off = 18
  !> The same of an effect that cannot be computed with what the scene asks for.
  integer, parameter :: of_barred = 19
  !> Estimated error of what was simulated, where it is above the tolerance.
  integer, parameter :: of_error = 20

  !> A kind of warning in words: `WHAT, SIZE MEASURE, ADVICE`. A star stands for the effect.
  type :: warning_kind
    character(len=16) :: name = ''             !! in one word
    real(real64) :: limit = 0.0_real64         !! below it there is none
    logical :: is_share = .false.              !! the size is told in percent
    character(len=64) :: what = ''             !! what is outside
    character(len=68) :: measure = ''          !! what the size is of
    character(len=120) :: advice = ''          !! what to do
  end type warning_kind

  !> All kinds, by their number.
  type(warning_kind), parameter :: warning_kinds(*) = [ &
    warning_kind('contact_radius', 0.3_real64, .false., &
      'a contact circle is wide for its sphere', 'of the radius of the summit (limit 0.3)', &
      'press less or take these contacts as an extrapolation of Hertz'), &
    warning_kind('cap', 0.0_real64, .true., &
      'a contact reaches beyond the cap of its asperity', &
      'of the radius of the summit beyond its plane', &
      'press less or give the asperity the height that it has'), &
    warning_kind('slope', 0.3_real64, .false., &
      'a contact is steep', 'of slope (limit 0.3)', &
      'expect errors of the order of its square in what friction and neighbours do'), &
    warning_kind('yield', 1.0_real64, .false., &
      'a contact is pressed beyond yield and plasticity is off', &
      'times the average pressure at which it yields', &
      'set plasticity = ''auto'' or press less'), &
    warning_kind('overlapping', 0.0_real64, .false., &
      'contact circles overlap and interaction is off', 'pairs', &
      'these contacts are not independent'), &
    warning_kind('crowding', 0.1_real64, .true., &
      'contacts cover much of the area and interaction is off', &
      'of the nominal area (limit 10 %)', &
      'these contacts are not independent'), &
    warning_kind('tabor', 0.045_real64, .false., &
      'a contact adheres by the law for small Tabor parameters', &
      'is its Tabor parameter (limit 0.045)', &
      'expect a pull-off that is too large by more than 1 %'), &
    warning_kind('creep_strain', 0.01_real64, .true., &
      'a contact creeps beyond the linear range', 'of strain (limit 1 %)', &
      'press less or expect more creep than is computed'), &
    warning_kind('relaxing', 0.0_real64, .true., &
      'the hold ends before relaxation is done', 'of the load or the closing still to come', &
      'hold longer if the end of it is wanted'), &
    warning_kind('not_together', 0.0_real64, .true., &
      'two effects have no common theory and one is left out', &
      'is the estimated share of the one left out', &
      'choose one of them by ''off'' and ''on'''), &
    warning_kind('load_direction', 0.0_real64, .true., &
      'the load is not the vertical load', 'is what they differ by', &
      'use control = ''vertical_load'' for a dead weight, or read vertical_load'), &
    warning_kind('map_edge', 0.0_real64, .true., &
      'hills that the edge cuts bear the map', &
      'of the load on its two outer rows where a flat punch bears less', &
      'take a larger map or another part of the surface'), &
    warning_kind('no_summit', 0.0_real64, .true., &
      'spots of the map without a summit bear load', 'of the load is on them', &
      'set interaction = ''boundary'': no sphere stands for them'), &
    warning_kind('scan_lines', 0.0_real64, .true., &
      'single scan lines bear load', 'of the load is on them', &
      'take what is noise of the instrument out of the map'), &
    warning_kind('spikes', 0.0_real64, .true., &
      'single outliers bear load', 'of the load is on them', &
      'set map_despike = ''on'' where they are no part of the surface'), &
    warning_kind('area', 0.0_real64, .true., &
      'the area is less sure than the tolerance', 'is its estimated error', &
      'take the area with this error, loads and approaches keep the tolerance'), &
    warning_kind('flat_map', 0.0_real64, .false., &
      'the map is flat', 'is the range of heights after levelling', &
      'check the level and the digits of the map if it should be rough'), &
    warning_kind('off', 0.0_real64, .true., &
      '* is off', 'is its estimated influence on the load', 'set * = ''auto'''), &
    warning_kind('barred', 0.0_real64, .true., &
      '* is left out, as it cannot be computed here', 'is its estimated influence on the load', &
      'take the load with this error'), &
    warning_kind('error', 0.0_real64, .true., &
      'the estimated error is above the tolerance', &
      'is that of the load, or of the compression where a load is asked for', &
      'take the results with this error')]

  !> One kind of warning at one position.
  type :: theory_warning
    integer :: kind = 0                  !! one of the `of_` numbers
    integer :: state = 0                 !! state of the position at which it is worst
    integer :: contacts = 0              !! for how many contacts it holds there; 0: for the state
    real(real64) :: size = 0.0_real64    !! in the measure of the kind
    character(len=32) :: whose = ''      !! which effects, where that is not known by the kind
  end type theory_warning

contains

  !> Adds a finding of one state to those of that state: the worst size of each kind stands, and
  !> contacts are counted.
  pure subroutine warn(list, kind, size_found, contacts, whose)
    type(theory_warning), allocatable, intent(inout) :: list(:)  !! of one state, by kind
    integer, intent(in) :: kind                                  !! one of the `of_` numbers
    real(real64), intent(in) :: size_found                       !! in the measure of the kind
    integer, intent(in), optional :: contacts                    !! how many; absent: of the state
    character(len=*), intent(in), optional :: whose              !! which effects
    integer :: at

    call find_place(list, kind, at)
    if (present(contacts)) list(at)%contacts = list(at)%contacts + contacts
    if (list(at)%size >= size_found) return
    ! Beyond the range of a double is as bad as can be told.
    list(at)%size = min(size_found, huge(size_found))
    if (present(whose)) list(at)%whose = whose
  end subroutine warn

  !> Adds the findings of a state to those of its position: the worst state of each kind stands, the
  !> first of equals.
  pure subroutine take_worse(list, found, state)
    type(theory_warning), allocatable, intent(inout) :: list(:)  !! of the position, by kind
    type(theory_warning), allocatable, intent(in) :: found(:)    !! of the state; or none
    integer, intent(in) :: state                                 !! which one, from 1
    integer :: at, i

    if (.not. allocated(found)) return
    do i = 1, size(found)
      call find_place(list, found(i)%kind, at)
      if (list(at)%size >= found(i)%size) cycle
      list(at) = found(i)
      list(at)%state = state
    end do
  end subroutine take_worse

  ! Finds the place of a kind in a list, which gets it when it has none.
  pure subroutine find_place(list, kind, at)
    type(theory_warning), allocatable, intent(inout) :: list(:)
    integer, intent(in) :: kind
    integer, intent(out) :: at

    if (.not. allocated(list)) allocate (list(0))
    at = count(list%kind < kind) + 1
    if (any(list%kind == kind)) return
    list = [list(:at - 1), theory_warning(kind=kind, size=-1.0_real64), list(at:)]
  end subroutine find_place

end module asperity_theory_warnings
