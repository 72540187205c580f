!> From the file of a height map to its summits: read, put in a unit, levelled, outliers taken out.
module asperity_summits_of_file
  use asperity_height_map, only: fault_of_spacing, give_spacing, height_map, length_units, &
                                 level_names, level_plane, periodic_edge, put_in_unit, usual_level
  use asperity_height_map_reader, only: read_height_map
  use asperity_kinds, only: int64, real64
  use asperity_map_despiking, only: despike_map
  use asperity_map_levelling, only: level_map
  use asperity_map_summits, only: find_summits, map_summits, rule_eight, rule_names, &
                                  usual_radius
  use asperity_problems, only: decimal_text, problem_list
  use asperity_summit_spheres, only: radius_names
  implicit none
  private

  public :: summit_choices, summits_of_file, summits_of_array, summits_of_samples

  !> How it is done.
  type :: summit_choices
    integer :: rule = rule_eight               !! what a summit is
    logical :: periodic = .false.              !! the map repeats itself
    integer :: level = 0                       !! from which heights are measured; 0: the usual one
    integer :: radius = 0                      !! rule for radii; 0: that of the rule
    integer :: unit = 0                        !! of `length_units`; 0: the file's own
    logical :: despike = .false.               !! take single outliers out
    real(real64) :: spacing(2) = 0.0_real64    !! of a matrix; 0 when not given
    logical :: progress = .false.              !! print the progress on a terminal
    character(len=2) :: prefix = ''            !! of a choice's name in messages: `--`, or none
  end type summit_choices

contains

  !> Reads a map and finds its summits. With problems, or when `failure` is allocated because there
  !> is no memory for it, neither is to be used.
  subroutine summits_of_file(path, choices, map, summits, spikes, problems, failure)
    character(len=*), intent(in) :: path                    !! the file
    type(summit_choices), intent(inout) :: choices          !! learns the rule for radii
    type(height_map), intent(out) :: map                    !! levelled
    type(map_summits), intent(out) :: summits               !! of the map
    integer(int64), intent(out) :: spikes                   !! removed; -1: not searched for
    type(problem_list), intent(inout) :: problems           !! what is wrong
    character(len=:), allocatable, intent(out) :: failure   !! why not

    spikes = -1_int64
    call check_choices(choices, problems)
    if (problems%count() > 0) return
    call read_height_map(path, choices%spacing, choices%progress, map, problems, failure, &
                         trim(choices%prefix) // 'spacing')
    if (problems%count() > 0 .or. allocated(failure)) return
    if (choices%unit > 0) call put_in_unit(map, choices%unit)
    call summits_of_samples(map, choices, summits, spikes, failure)
    if (allocated(failure)) failure = path // ': ' // failure
  end subroutine summits_of_file

  !> The same of a map in memory, which has its own edge.
  subroutine summits_of_array(map, choices, summits, spikes, problems, failure)
    type(height_map), intent(inout) :: map                  !! from take_map; then levelled
    type(summit_choices), intent(inout) :: choices          !! learns the edge, the rule for radii
    type(map_summits), intent(out) :: summits               !! of the map
    integer(int64), intent(out) :: spikes                   !! removed; -1: were not looked for
    type(problem_list), intent(inout) :: problems           !! what is wrong
    character(len=:), allocatable, intent(out) :: failure   !! why there are none
    character(len=:), allocatable :: fault

    spikes = -1_int64
    choices%periodic = map%edge == periodic_edge
    call check_choices(choices, problems)
    fault = fault_of_spacing(choices%spacing, trim(choices%prefix) // 'spacing')
    if (fault == '') &
      call give_spacing(map, choices%spacing, trim(choices%prefix) // 'spacing', .false., fault)
    if (fault /= '') call problems%add(fault)
    if (problems%count() > 0) return
    if (choices%unit > 0) call put_in_unit(map, choices%unit)
    call summits_of_samples(map, choices, summits, spikes, failure)
  end subroutine summits_of_array

  ! That every choice is one.
  subroutine check_choices(choices, problems)
    type(summit_choices), intent(inout) :: choices
    type(problem_list), intent(inout) :: problems

    if (choices%level == 0) choices%level = usual_level(choices%periodic)
    if (choices%periodic .and. choices%level == level_plane) &
      call problems%add(trim(choices%prefix) // &
                        'level: a periodic map without its plane would ' // &
                        'not be periodic: found plane, expected mean or none')
    call check_choice('rule', choices%rule, 1, size(rule_names))
    call check_choice('level', choices%level, 1, size(level_names))
    call check_choice('radius', choices%radius, 0, size(radius_names))
    call check_choice('unit', choices%unit, 0, size(length_units))

  contains

    subroutine check_choice(name, choice, least, most)
      character(len=*), intent(in) :: name
      integer, intent(in) :: choice, least, most

      if (choice < least .or. choice > most) &
        call problems%add(name // ': found ' // decimal_text(choice) // ', expected a number ' // &
                          'from ' // decimal_text(least) // ' to ' // decimal_text(most))
    end subroutine check_choice

  end subroutine check_choices

  !> The same of a map that was read: levels it and takes outliers out as chosen.
  subroutine summits_of_samples(map, choices, summits, spikes, failure)
    type(height_map), intent(inout) :: map                  !! read, then levelled
    type(summit_choices), intent(inout) :: choices          !! learns the rule for radii
    type(map_summits), intent(out) :: summits               !! of the map
    integer(int64), intent(out) :: spikes                   !! removed; -1: not searched for
    character(len=:), allocatable, intent(out) :: failure   !! why not

    spikes = -1_int64
    if (choices%level == 0) choices%level = usual_level(choices%periodic)
    map%periodic = choices%periodic
    call level_map(map, choices%level)
    if (choices%despike) call despike_map(map, choices%level, choices%progress, spikes, failure)
    if (choices%radius == 0) choices%radius = usual_radius(choices%rule)
    if (.not. allocated(failure)) &
      call find_summits(map, choices%rule, choices%radius, summits, failure)
  end subroutine summits_of_samples

end module asperity_summits_of_file
