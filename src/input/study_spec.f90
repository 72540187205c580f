!> Reads what `asperity study` shall study: text in, checked values or a list of problems out.
!>
!> The text is a specification of random surfaces (`asperity_generation_spec`) with two groups more,
!> &material and &study.
module asperity_study_spec
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_file_kind, only: a_specification, a_study
  use asperity_generation_spec, only: take_generation
  use asperity_generation_values, only: generation_spec
  use asperity_input_text, only: read_text
  use asperity_kinds, only: real64
  use asperity_problems, only: problem_list
  use asperity_scene_fields, only: read_fields, scene_fields
  use asperity_spec_names, only: most_sizes, spec_table
  implicit none
  private

  public :: study_spec, read_study_spec
  public :: against_plane, places_grid, places_random, reference_integral, reference_largest

  integer, parameter :: against_surface = 1   !! the upper surface meets the lower one
  integer, parameter :: against_plane = 2     !! it meets a plane of the lower one's material

  integer, parameter :: places_grid = 1       !! sections side by side
  integer, parameter :: places_random = 2     !! sections anywhere

  integer, parameter :: reference_integral = 1  !! sections are compared with the integral
  integer, parameter :: reference_largest = 2   !! compared with the mean of the largest size

  !> A whole study.
  type :: study_spec
    type(generation_spec) :: surfaces                  !! the ensemble
    character(len=:), allocatable :: text              !! the file itself
    type(decimal_value) :: elastic_modulus(2)          !! upper, lower; more than 0
    type(decimal_value) :: poisson_ratio(2)            !! upper, lower
    integer :: against = against_surface               !! what the upper surface meets
    logical :: at_pressure = .false.                   !! the pressure is given
    type(decimal_value) :: separation                  !! of the reference planes, else
    type(decimal_value) :: pressure                    !! vertical load on an area, more than 0
    real(real64), allocatable :: sizes(:)              !! sides of sections, descending; may be
                                                       !! empty: then from the whole down
    real(real64) :: factor = 2.0_real64                !! from one size to the next, more than 1
    integer :: steps = 6                               !! how many sizes
    integer :: sections = 100                          !! of a size on a surface, at most
    integer :: places = places_grid                    !! where they are
    integer :: reference = reference_integral          !! what a section is compared with
    real(real64) :: tolerance = 0.1_real64             !! how near it must be, share of that
    real(real64) :: confidence = 0.95_real64           !! share of the sections that must be
  end type study_spec

contains

  !> Reads and checks a specification. With problems it is not to be used.
  subroutine read_study_spec(path, spec, problems)
    character(len=*), intent(in) :: path         !! path of the specification; `-` is standard input
    type(study_spec), intent(out) :: spec        !! its values, defaults filled in
    type(problem_list), intent(out) :: problems  !! all that is wrong
    type(scene_fields) :: fields

    spec%surfaces%file = path
    call read_text(path, 'a specification', spec%text, problems)
    if (problems%count() > 0) return
    call read_fields(path, spec%text, 'a specification', [a_specification, a_study], &
                     spec_table(of_study=.true.), fields)
    if (fields%is_text) call take_study(fields, spec)
    problems = fields%problems
    spec%surfaces%notes = fields%notes
  end subroutine read_study_spec

  !> All groups.
  subroutine take_study(fields, spec)
    type(scene_fields), intent(inout) :: fields
    type(study_spec), intent(inout) :: spec

    call take_generation(fields, spec%surfaces)
    if (spec%surfaces%is_deck) &
      call fields%complain_of_group('deck', 'group &deck: found in a study, expected none')
    if (fields%has_name('random', 'ensemble') .and. spec%surfaces%ensemble < 2) &
      call fields%complain_of('random', 'ensemble', 'found fewer than 2 surfaces, expected ' // &
                              '2 or more, as their spread is studied')
    call fields%require_name('random', 'ensemble', 'the number of surfaces, 2 or more')
    call fields%take('material', 'elastic_modulus', spec%elastic_modulus)
    call fields%take('material', 'poisson_ratio', spec%poisson_ratio)
    call fields%take('study', 'against', spec%against)
    call fields%take('study', 'separation', spec%separation)
    call fields%take('study', 'pressure', spec%pressure)
    spec%at_pressure = fields%has_name('study', 'pressure')
    if (.not. (spec%at_pressure .or. fields%has_name('study', 'separation'))) &
      call fields%complain_of_group('study', 'no separation and no pressure in &study, ' // &
                                    'expected one of them')
    call take_sections(fields, spec)
  end subroutine take_study

  !> Takes how sections are cut out, and when one is representative.
  subroutine take_sections(fields, spec)
    type(scene_fields), intent(inout) :: fields
    type(study_spec), intent(inout) :: spec
    type(decimal_value), allocatable :: sizes(:)
    type(decimal_value) :: confidence, factor, tolerance
    integer :: number

    number = fields%value_count('study', 'sizes')
    allocate (sizes(min(number, most_sizes)))
    call fields%take('study', 'sizes', sizes)
    spec%sizes = decimal_to_real64(sizes)
    if (number <= most_sizes .and. all(sizes%all_digits > 0)) then
      if (.not. all(spec%sizes(2:) < spec%sizes(:number - 1))) &
        call fields%complain_of('study', 'sizes', 'found sizes in another order, expected ' // &
                                'each to be smaller than the one before')
    end if
    call fields%take('study', 'factor', factor)
    call fields%take('study', 'steps', spec%steps)
    call fields%take('study', 'sections', spec%sections)
    call fields%take('study', 'places', spec%places)
    call fields%take('study', 'reference', spec%reference)
    call fields%take('study', 'tolerance', tolerance)
    call fields%take('study', 'confidence', confidence)
    spec%factor = decimal_to_real64(factor)
    spec%tolerance = decimal_to_real64(tolerance)
    spec%confidence = decimal_to_real64(confidence)
  end subroutine take_sections

end module asperity_study_spec
