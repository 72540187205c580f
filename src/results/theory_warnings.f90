!> Warnings: results outside the range of a theory, or in error by the model, the data or the grid.
!> They are part of the results of a position; the program prints them.
!>
!> Sources of the limits: docs/reference/warnings.md.
module asperity_theory_warnings
  use asperity_kinds, only: real64
  implicit none
  private

  public :: theory_warning, warning_kind, warning_kinds, class_names, add_warning, are_alike, &
            take_worse, warn_above
  public :: of_contact_radius, of_cap, of_slope, of_yield, of_overlapping, of_crowding, of_tabor, &
            of_creep_strain, of_relaxing, of_together, of_load_direction, of_map_edge, &
            of_scan_lines, of_spikes, of_area, of_limit, of_range, &
            of_unlike_bodies, of_yield_strain, of_flow_depth, of_unloading_depth, of_missing, &
            of_border, of_resolution, of_flat_map, of_off, of_barred, of_error, &
            of_nested, of_excluded, of_attraction, of_held_gap, of_cut_range, of_shrinking, &
            of_map_slope, of_map_pressure, of_not_estimated, of_edge_pressure

  !> Places of the kinds in `warning_kinds`, where each is described.
  enum, bind(c)
    enumerator :: of_contact_radius = 1, of_cap, of_slope, of_yield, of_overlapping, of_crowding, &
      of_tabor, of_creep_strain, of_relaxing, of_together, of_load_direction, of_map_edge, &
      of_scan_lines, of_spikes, of_area, of_limit, of_range, of_unlike_bodies, &
      of_yield_strain, of_flow_depth, of_unloading_depth, of_missing, of_border, of_resolution, &
      of_flat_map, of_off, of_barred, of_error, of_nested, of_excluded, of_attraction, &
      of_held_gap, of_cut_range, of_shrinking, of_map_slope, of_map_pressure, of_not_estimated, &
      of_edge_pressure
  end enum

  !> Classes of kinds: a result outside the range of a theory; a result whose numbers are in error,
  !> by what the model, the data or the grid leave out.
  integer, parameter :: in_theory = 1, in_accuracy = 2
  !> Names of the classes.
  character(len=*), parameter :: class_names(2) = [character(len=8) :: 'theory', 'accuracy']

  !> A kind of warning in words: `WHAT, SIZE MEASURE, ADVICE`. A star stands for the effect.
  type :: warning_kind
    character(len=16) :: name = ''             !! name, one word
    integer :: class = in_theory               !! `in_theory` or `in_accuracy`
    real(real64) :: limit = 0.0_real64         !! no warning up to it; 0: set by the caller
    logical :: is_share = .false.              !! the size is printed in percent
    character(len=64) :: what = ''             !! what is outside the theory
    character(len=72) :: measure = ''          !! the quantity of the size
    character(len=120) :: advice = ''          !! what a user can do
    !> advice where another effect, `whose`, excludes the one of `advice`
    character(len=72) :: other_advice = ''
  end type warning_kind

  !> All kinds, by their number.
  type(warning_kind), parameter :: warning_kinds(*) = [ &
    warning_kind('contact_radius', in_theory, 0.3_real64, .false., &
      'a contact circle is wide for its sphere', 'of the radius of the sphere (limit 0.3)', &
      'reduce the load or take these contacts as an extrapolation of Hertz'' theory'), &
    warning_kind('cap', in_theory, 0.0_real64, .true., &
      'a contact extends below the base of its spherical cap', 'of the radius', &
      'reduce the load or increase the height of the asperities', &
      'reduce the load or set interaction = ''boundary'''), &
    warning_kind('slope', in_theory, 0.3_real64, .false., &
      'a contact or a reference plane is steep', 'is the slope (limit 0.3)', &
      'expect relative errors of the order of the square of the slope'), &
    warning_kind('yield', in_theory, 1.0_real64, .false., &
      'a contact is loaded beyond yield and plasticity is off', &
      'times the average pressure at yield', &
      'set plasticity = ''auto'' or reduce the load', 'reduce the load'), &
    warning_kind('overlapping', in_theory, 0.0_real64, .false., &
      'contact circles overlap and interaction is off', 'pairs', &
      'these contacts are not independent'), &
    warning_kind('crowding', in_theory, 0.1_real64, .true., &
      'contacts cover much of the area and interaction is off', &
      'of the nominal area (limit 10 %)', &
      'these contacts are not independent'), &
    warning_kind('tabor', in_theory, 0.045_real64, .false., &
      'a contact adheres by the law for small Tabor parameters', &
      'is the Tabor parameter (limit 0.045)', &
      'expect a pull-off force that is more than 1 % too large'), &
    warning_kind('creep_strain', in_theory, 0.01_real64, .true., &
      'a contact creeps beyond the linear range', 'of strain (limit 1 %)', &
      'reduce the load or expect more creep than is computed'), &
    warning_kind('relaxing', in_accuracy, 0.0_real64, .true., &
      'the hold ends before relaxation is done', &
      'of the load or of the compression still to come', &
      'increase hold_time if the final state is needed'), &
    warning_kind('not_together', in_accuracy, 0.0_real64, .true., &
      'two effects have no common theory and one is left out', &
      'is the estimated share of the one left out', &
      'choose one of them by ''off'' and ''on'''), &
    warning_kind('load_direction', in_theory, 0.0_real64, .true., &
      'total normal force and vertical load differ', 'of the total normal force', &
      'use control = ''vertical_load'' for a dead weight or read vertical_load'), &
    warning_kind('map_edge', in_accuracy, 0.0_real64, .true., &
      'the edge cuts hills that carry load', &
      'of the load is on the outer 2 pixel rows, more than under a flat punch', &
      'take a larger map or another part of the surface'), &
    warning_kind('scan_lines', in_accuracy, 0.0_real64, .true., &
      'single scan lines carry load', 'of the load', &
      'remove the noise of the instrument from the map'), &
    warning_kind('spikes', in_accuracy, 0.0_real64, .true., &
      'single outliers carry load', 'of the load', &
      'set map_despike = ''on'' where they are not part of the surface', &
      'displace the maps by whole pixels or smooth their steps'), &
    warning_kind('area', in_accuracy, 0.0_real64, .true., &
      'the area is less sure than the tolerance', 'is its estimated error', &
      'use the area with this error: loads and separations keep the tolerance'), &
    warning_kind('limit', in_theory, 1.0_real64, .false., &
      'a contact exceeds the limit of the scene and plasticity is off', 'times the limit', &
      'set plasticity = ''auto'' or reduce the load', 'reduce the load'), &
    warning_kind('adhesion_range', in_theory, 0.045_real64, .true., &
      'adhesion acts farther than a sphere is a paraboloid', &
      'is equilibrium_distance over the radius (limit 4.5 %)', &
      'reduce equilibrium_distance or expect wrong pulls'), &
    warning_kind('unlike_bodies', in_theory, 0.0_real64, .true., &
      'creep takes both bodies for one solid and they are unlike', &
      'of the compliance relaxes by the solid of the softer body', &
      'expect an error of this order in what relaxes'), &
    warning_kind('yield_strain', in_theory, 0.0073_real64, .true., &
      'the yield strain is beyond the fit of plasticity', &
      'is the yield stress over the combined modulus (limit 0.73 %)', &
      'take load and area of plastic contacts as an extrapolation'), &
    warning_kind('flow_depth', in_theory, 110.0_real64, .false., &
      'a contact flows beyond the fit of plasticity on loading', &
      'times the critical overlap (limit 110)', &
      'reduce the load or take these contacts as an extrapolation'), &
    warning_kind('unloading_depth', in_theory, 170.0_real64, .false., &
      'a contact is unloaded from beyond the fit of plasticity', &
      'times the critical overlap (limit 170)', &
      'reduce the largest load or take these contacts as an extrapolation'), &
    warning_kind('missing', in_accuracy, 0.0_real64, .true., &
      'missing pixels of the map carry no load', 'of the pixels are missing', &
      'fill them or expect a load that is too small by about this share'), &
    warning_kind('border', in_theory, 2.0_real64, .false., &
      'the map is not periodic although map_edge is', &
      'times the roughest inner line of pixels across its border (limit 2)', &
      'set map_edge = ''free'' or take a periodic map'), &
    warning_kind('resolution', in_accuracy, 0.1_real64, .true., &
      'contact patches are not resolved by the pixels of the map', &
      'is the estimated error of their area (limit 10 %)', &
      'take a map of finer pixels or the area with this error', &
      'take area and pressures as those of these pixels: finer ones change them'), &
    warning_kind('flat_map', in_accuracy, 0.0_real64, .false., &
      'the map is flat', 'is the range of heights after levelling', &
      'check the level and the digits of the map if it should be rough'), &
    warning_kind('off', in_accuracy, 0.0_real64, .true., &
      '* is off', 'is its estimated influence on the load', 'set * = ''auto'''), &
    warning_kind('barred', in_accuracy, 0.0_real64, .true., &
      '* is left out, as it cannot be computed here', 'is its estimated influence on the load', &
      'take the load with this error'), &
    warning_kind('error', in_accuracy, 0.0_real64, .true., &
      'the estimated error is above the tolerance', &
      'is that of the load, or of the compression where a load is asked for', &
      'take the results with this error'), &
    warning_kind('nested', in_accuracy, 0.02_real64, .true., &
      'a contact overlaps the circle of one 3 times blunter', &
      'of the load: error_estimate may be too small (limit 2 %)', &
      'set interaction = ''auto'', which resolves them', &
      'expect an error of up to 10 times error_estimate'), &
    warning_kind('excluded', in_accuracy, 0.0_real64, .true., &
      '* is off and has no common theory with another effect here', &
      'is its estimated influence on the load', 'take the load with this error'), &
    warning_kind('attraction', in_accuracy, 1.0_real64, .false., &
      'the pixels are wide for the range of adhesion', &
      'times the spacing that resolves it (limit 1)', &
      'take finer pixels or expect jumps of single ones'), &
    warning_kind('held_gap', in_theory, 0.0_real64, .false., &
      'adhesion on a periodic map holds the mean gap at each separation', &
      'states at prescribed separations', &
      'prescribe the load: a mean gap that is held leaves results that depend on the states'), &
    warning_kind('cut_range', in_accuracy, 0.0_real64, .true., &
      'the map ends within the range of adhesion', &
      'of the work of adhesion is left in the gap at its edge', &
      'take a wider map or expect a pull that is too small by up to this share'), &
    warning_kind('shrinking', in_theory, 0.0_real64, .true., &
      'contacts shrink beside others, beyond the theory of creep', &
      'of the elastic load is that of contacts that shrink', &
      'take their loads as estimates or solve the surface as a height map'), &
    warning_kind('map_slope', in_theory, 0.3_real64, .false., &
      'the map is steep', 'is its rms slope (limit 0.3)', &
      'check the unit of its heights or expect errors of the order of the square of the slope'), &
    warning_kind('map_pressure', in_theory, 0.19_real64, .true., &
      'pressures are near the contact modulus', &
      'of the modulus is the greatest (limit 19 %)', &
      'check the units of heights and modulus or take strains as beyond the linear theory'), &
    warning_kind('not_estimated', in_accuracy, 0.0_real64, .false., &
      '* is left out and has no estimate', '', &
      'take the results as those without *: its influence may be of any size'), &
    warning_kind('edge_pressure', in_accuracy, 0.0_real64, .true., &
      'an edge of the map cuts contact patches', 'of the load is on the pixels there', &
      'take no greatest pressure from it: it grows without limit with finer pixels')]

  !> One kind of warning at one position.
  type :: theory_warning
    real(real64) :: magnitude = 0.0_real64  !! size in the measure of the kind
    integer :: number = 0                !! one of the `of_` numbers
    integer :: state = 0                 !! state of the position with the largest size
    integer :: contacts = 0              !! number of contacts; 0: of the whole state
    character(len=36) :: whose = ''      !! effects of the warning, unless set by the kind
  end type theory_warning

contains

  !> Whether two warnings are of one kind, and of one effect where the kind names an effect.
  elemental logical function are_alike(one, other)
    type(theory_warning), intent(in) :: one    !! of any kind
    type(theory_warning), intent(in) :: other  !! of any kind

    are_alike = one%number == other%number
    if (.not. are_alike) return
    if (one%number == of_together .or. index(warning_kinds(one%number)%what, '*') > 0) &
      are_alike = one%whose == other%whose
  end function are_alike

  !> Adds a warning to those of a state: of alike ones the largest size and the sum of contacts.
  pure subroutine add_warning(list, number, size_found, contacts, whose)
    type(theory_warning), allocatable, intent(inout) :: list(:)  !! warnings of a state, by kind
    integer, intent(in) :: number                                !! one of the `of_` numbers
    real(real64), intent(in) :: size_found                       !! size in the measure of the kind
    integer, intent(in), optional :: contacts                    !! number; absent: of the state
    character(len=*), intent(in), optional :: whose              !! effects of the warning
    type(theory_warning) :: new
    integer :: at

    new%number = number
    if (present(whose)) new%whose = whose
    call find_place(list, new, at)
    if (present(contacts)) list(at)%contacts = list(at)%contacts + contacts
    if (list(at)%magnitude >= size_found) return
    ! A size beyond the range of a double is reported as the largest double.
    list(at)%magnitude = min(size_found, huge(size_found))
    if (present(whose)) list(at)%whose = whose
  end subroutine add_warning

  !> Adds a warning where a size exceeds the limit of its kind by more than rounding.
  pure subroutine warn_above(list, number, size_found, contacts, whose)
    type(theory_warning), allocatable, intent(inout) :: list(:)  !! warnings of a state, by kind
    integer, intent(in) :: number                                !! one of the `of_` numbers
    real(real64), intent(in) :: size_found                       !! size in the measure of the kind
    integer, intent(in), optional :: contacts                    !! number; absent: of the state
    character(len=*), intent(in), optional :: whose              !! effects of the warning
    real(real64), parameter :: rounding = 1.0e-9_real64

    associate (limit => warning_kinds(number)%limit)
      if (size_found > limit + rounding * max(1.0_real64, limit)) &
        call add_warning(list, number, size_found, contacts, whose)
    end associate
  end subroutine warn_above

  !> Adds the warnings of a state to those of its position: of alike ones the first of the largest
  !> size.
  pure subroutine take_worse(list, found, state)
    type(theory_warning), allocatable, intent(inout) :: list(:)  !! warnings of a position
    type(theory_warning), allocatable, intent(in) :: found(:)    !! warnings of the state, or none
    integer, intent(in) :: state                                 !! number of the state, from 1
    integer :: at, i

    if (.not. allocated(found)) return
    do i = 1, size(found)
      call find_place(list, found(i), at)
      if (list(at)%magnitude >= found(i)%magnitude) cycle
      list(at) = found(i)
      list(at)%state = state
    end do
  end subroutine take_worse

  ! Finds the place of a warning that is alike; adds one of no size behind those of its kind if
  ! there is none.
  pure subroutine find_place(list, new, at)
    type(theory_warning), allocatable, intent(inout) :: list(:)
    type(theory_warning), intent(in) :: new
    integer, intent(out) :: at

    if (.not. allocated(list)) allocate (list(0))
    at = findloc(are_alike(list, new), .true., 1)
    if (at > 0) return
    at = count(list%number <= new%number) + 1
    list = [list(:at - 1), theory_warning(number=new%number, magnitude=-1.0_real64), list(at:)]
  end subroutine find_place

end module asperity_theory_warnings
