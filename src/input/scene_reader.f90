!> Reads a scene, or a card deck in its place: text in, checked values or a list of problems out.
module asperity_scene_reader
  use asperity_card_deck, only: has_cards
  use asperity_constants, only: pi
  use asperity_file_kind, only: a_scene, group_start, other_kind
  use asperity_height_map, only: copy_map
  use asperity_input_text, only: blanks, read_text
  use asperity_kinds, only: real64
  use asperity_library_turn, only: library_turn
  use asperity_namelist_text, only: skip_blanks
  use asperity_problems, only: problem_list, real_text
  use asperity_scene_deck, only: surfaces_from_deck
  use asperity_scene_effects, only: read_effects
  use asperity_scene_fields, only: read_fields, scene_fields
  use asperity_scene_loading, only: check_states, read_limit, read_loading
  use asperity_scene_layers, only: check_layers, read_bodies
  use asperity_scene_maps, only: check_map_scene
  use asperity_scene_names, only: scene_rows, scene_table
  use asperity_scene_surfaces, only: from_csv, read_surfaces
  use asperity_scene_values, only: by_word, dundurs_beta, is_coupled, scene, scene_motion, &
                                   scene_side, scene_surface
  implicit none
  private

  public :: read_scene, parse_scene, build_scene, build_scene_of, rebuild_scene

contains

  !> Reads and checks a scene or a card deck. With problems the scene is not to be used.
  subroutine read_scene(path, checked, problems)
    character(len=*), intent(in) :: path         !! path of the scene or deck; `-` is standard input
    type(scene), intent(out) :: checked          !! its values, defaults filled in
    type(problem_list), intent(out) :: problems  !! all that is wrong, in all files it names
    character(len=:), allocatable :: text
    type(library_turn) :: turn

    call turn%begin()
    call read_text(path, 'a scene or a card deck', text, problems)
    if (problems%count() > 0) return
    if (is_scene(path, text)) then
      call parse_scene(path, text, checked, problems)
    else
      call deck_as_scene(path, text, checked, problems)
    end if
  end subroutine read_scene

  !> Checks the text of a scene. `path` serves the messages, and files are named relative to it.
  subroutine parse_scene(path, text, checked, problems)
    character(len=*), intent(in) :: path         !! the scene's file
    character(len=*), intent(in) :: text         !! the whole scene
    type(scene), intent(out) :: checked          !! its values, defaults filled in
    type(problem_list), intent(out) :: problems  !! all that is wrong, in all files it names
    type(scene_fields) :: fields
    type(library_turn) :: turn

    call turn%begin()
    checked%file = path
    checked%text = text
    call read_fields(path, text, 'a scene', [a_scene], scene_table(), fields)
    call read_groups(fields, checked, problems)
  end subroutine parse_scene

  !> Makes a scene of two surfaces in memory. `text` has the groups of a scene, of `&surfaces` only
  !> what does not name them, for instance
  !> `&material ... / &loading control = 'load', value = 500. /`.
  subroutine build_scene(upper, lower, text, checked, problems)
    type(scene_surface), intent(in) :: upper, lower !! surfaces from `take_surface`
    character(len=*), intent(in) :: text            !! the other groups
    type(scene), intent(out) :: checked             !! its values, defaults filled in
    type(problem_list), intent(inout) :: problems   !! all that is wrong
    type(scene_side) :: sides(2)

    allocate (sides(1)%surface, source=upper)
    allocate (sides(2)%surface, source=lower)
    call build_scene_of(sides, text, checked, problems)
  end subroutine build_scene

  !> Makes a scene of its text and of surfaces or height maps in memory; a side that is not given is
  !> named in the text, as in a file.
  subroutine build_scene_of(sides, text, checked, problems)
    type(scene_side), intent(in) :: sides(2)        !! upper and lower side
    character(len=*), intent(in) :: text            !! text of all groups
    type(scene), intent(out) :: checked             !! its values, defaults filled in
    type(problem_list), intent(inout) :: problems   !! all that is wrong
    type(scene_fields) :: fields
    character(len=:), allocatable :: failure
    integer :: side
    type(library_turn) :: turn

    call turn%begin()
    checked%file = 'scene'
    checked%text = text
    call read_fields(checked%file, text, 'a scene', [a_scene], scene_table(), fields)
    do side = 1, 2
      fields%given(side) = allocated(sides(side)%surface) .or. allocated(sides(side)%map)
    end do
    if (allocated(sides(1)%map) .or. allocated(sides(2)%map)) allocate (checked%map)
    if (allocated(sides(1)%map)) call copy_map(sides(1)%map, checked%map%upper, failure)
    if (allocated(sides(2)%map) .and. .not. allocated(failure)) &
      call copy_map(sides(2)%map, checked%map%lower, failure)
    if (allocated(failure)) then
      call problems%add(failure)
      problems%lacks_memory = .true.
      return
    end if
    if (allocated(sides(1)%surface)) checked%upper = sides(1)%surface
    if (allocated(sides(2)%surface)) checked%lower = sides(2)%surface
    call read_groups(fields, checked, problems)
  end subroutine build_scene_of

  !> Makes a scene with the surfaces of another one, which are not read again, from the text of all
  !> its groups. &surfaces of the text is not looked at: that of the other scene stays. Surfaces of
  !> a deck are read anew, as the deck brings material and slopes, too.
  subroutine rebuild_scene(other, text, checked, problems)
    type(scene), intent(in) :: other              !! read or built without problems
    character(len=*), intent(in) :: text          !! text of all groups
    type(scene), intent(out) :: checked           !! its values, defaults filled in
    type(problem_list), intent(out) :: problems   !! all that is wrong with the text
    type(scene_fields) :: fields
    type(library_turn) :: turn

    call turn%begin()
    if (other%from_deck) then
      call parse_scene(other%file, text, checked, problems)
      return
    end if
    checked%file = other%file
    checked%text = text
    checked%upper = as_in_its_file(other%upper)
    checked%lower = as_in_its_file(other%lower)
    if (allocated(other%map)) checked%map = other%map
    checked%nominal_area = other%nominal_area
    checked%stored = other%stored
    checked%units = other%units
    call read_fields(checked%file, text, 'a scene', [a_scene], scene_table(), fields)
    fields%given = .true.
    fields%surfaces_kept = .true.
    call read_groups(fields, checked, problems)
  end subroutine rebuild_scene

  ! A surface without what other groups than &surfaces say of it.
  pure type(scene_surface) function as_in_its_file(surface) result(bare)
    type(scene_surface), intent(in) :: surface

    bare = surface
    bare%elastic_modulus = 0.0_real64
    bare%poisson_ratio = 0.0_real64
    bare%slope = 0.0_real64
    bare%rotation = 0.0_real64
  end function as_in_its_file

  !> All groups, in the order in which they need each other.
  subroutine read_groups(fields, checked, problems)
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(inout) :: checked
    type(problem_list), intent(inout) :: problems
    real(real64), parameter :: most_unlike = 0.1_real64  ! 0.3 % of the load without slip; chosen
    type(problem_list) :: other_files
    integer :: i

    if (fields%is_text) then
      call read_surfaces(checked%file, fields, checked, other_files)
      fields%lacks_file = other_files%count() > 0
      call read_material(fields, checked)
      call read_motion(fields, checked%motion)
      call read_tilt(fields, checked)
      call read_loading(fields, checked)
      call read_limit(fields, checked)
      call read_effects(fields, checked)
      do i = 1, size(scene_rows)
        associate (row => scene_rows(i))
          if (row%stored .and. .not. (fields%surfaces_kept .and. row%group == 'surfaces')) &
            call fields%take(trim(row%group), trim(row%name), checked%stored(i))
        end associate
      end do
      call note_unlike_bodies()
      call check_states(fields, checked)
      call check_layers(fields, checked)
      call check_map_scene(fields, checked)
    end if
    call checked%notes%append(fields%notes)
    call problems%append(fields%problems)
    call problems%append(other_files)
    checked%is_checked = fields%problems%count() + other_files%count() == 0

  contains

    ! Notes that shear by the normal load of unlike bodies is left out. Without slip the load of a
    ! contact circle is larger by ln((1 + beta)/(1 - beta))/(2 beta) (Spence 1968).
    subroutine note_unlike_bodies()
      real(real64) :: beta

      beta = abs(dundurs_beta(checked))
      if (beta > most_unlike .and. .not. is_coupled(checked)) &
        call checked%notes%add(checked%file // ': note: unlike bodies, ' // &
        'Dundurs'' beta ' // real_text(beta, 'f6.3') // ': shear by the normal load is left ' // &
        'out, without slip it increases the load of a contact circle by ' // &
        real_text(100.0_real64 * (log((1 + beta) / (1 - beta)) / (2 * beta) - 1), 'f5.1') // ' %')
    end subroutine note_unlike_bodies

  end subroutine read_groups

  !> A deck in the place of a scene is the thesis' sweep over it.
  subroutine deck_as_scene(path, text, checked, problems)
    character(len=*), intent(in) :: path, text
    type(scene), intent(inout) :: checked
    type(problem_list), intent(inout) :: problems
    type(scene_motion) :: sweep
    character(len=:), allocatable :: other

    checked%file = path
    checked%text = text
    other = other_kind(text, [a_scene])
    if (other /= '') then
      call problems%add_at(1, 1, other // '; expected a scene or a card deck')
      return
    end if
    if (verify(text, blanks) == 0) then
      call problems%add_at(1, 1, 'the file is empty, expected a scene or a card deck')
      return
    end if
    call surfaces_from_deck(path, checked, sweep, problems, text)
    checked%is_checked = problems%count() == 0
    checked%motion = sweep
    ! The thesis has no interaction.
    checked%effects%given = by_word
  end subroutine deck_as_scene

  !> Whether a file is meant as a scene: a group begins one of its lines, it is named so, or it is
  !> nothing but comments, or it has no card of numbers behind the first card, as a deck has, and is
  !> of no other kind.
  pure logical function is_scene(path, text)
    character(len=*), intent(in) :: path, text
    integer :: at

    at = 1
    call skip_blanks(text, at)
    is_scene = group_start(text) > 0 .or. (at > len(text) .and. index(text, '!') > 0)
    if (is_scene .or. verify(text, blanks) == 0) return
    is_scene = index(path, '.scene', back=.true.) == max(1, len(path) - 5) .or. &
               (other_kind(text, [a_scene]) == '' .and. .not. has_cards(text))
  end function is_scene

  !> Group &material. A deck brings its own; CSV files do not. The combined modulus may stand for
  !> the moduli and ratios of both surfaces.
  subroutine read_material(fields, checked)
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(inout) :: checked
    character(len=*), parameter :: both_or_one = 'one for upper and lower, or contact_modulus'
    character(len=*), parameter :: beside_modulus = 'found beside contact_modulus, which ' // &
      'stands for the moduli and ratios of both surfaces, expected one or the other'

    call read_bodies(fields, checked)
    call fields%take('material', 'electrical_conductivity', checked%conductivity(:, 1))
    call fields%take('material', 'thermal_conductivity', checked%conductivity(:, 2))
    call fields%take('material', 'contact_modulus', checked%contact_modulus)
    if (fields%has_name('material', 'contact_modulus')) then
      call fields%refuse_name('material', 'elastic_modulus', beside_modulus)
      call fields%refuse_name('material', 'poisson_ratio', beside_modulus)
      call fields%refuse_name('material', 'layer_thickness', beside_modulus)
      return
    end if
    if (.not. from_csv(fields)) return
    call fields%require_name('material', 'elastic_modulus', both_or_one)
    call fields%require_name('material', 'poisson_ratio', both_or_one)
  end subroutine read_material

  !> Group &motion; without it one position at zero displacement.
  subroutine read_motion(fields, motion)
    type(scene_fields), intent(inout) :: fields
    type(scene_motion), intent(inout) :: motion

    call fields%take('motion', 'x_first', motion%x_first)
    call fields%take('motion', 'x_step', motion%x_step)
    call fields%take('motion', 'y_first', motion%y_first)
    call fields%take('motion', 'y_step', motion%y_step)
    call fields%take('motion', 'positions', motion%positions)
    if (.not. (ends_well(motion%x_first, motion%x_step) .and. &
               ends_well(motion%y_first, motion%y_step))) &
      call fields%complain_of_group('motion', 'the last position is beyond the range of a ' // &
                                    'double, expected a smaller step or fewer positions')

  contains

    pure logical function ends_well(first, step)
      real(real64), intent(in) :: first, step
      real(real64) :: share_of_range, steps

      ! In units of the largest double, so that nothing overflows on the way.
      steps = real(motion%positions - 1, real64)
      share_of_range = first / huge(steps) + step / huge(steps) * steps
      ends_well = abs(share_of_range) < 1.0_real64
    end function ends_well

  end subroutine read_motion

  !> Group &tilt. A deck brings its angles and the thesis' slopes.
  subroutine read_tilt(fields, checked)
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(inout) :: checked
    real(real64) :: rotation(2)
    real(real64) :: largest

    call fields%take('tilt', 'upper_slope', checked%upper%slope)
    call fields%take('tilt', 'lower_slope', checked%lower%slope)
    rotation = [checked%upper%rotation, checked%lower%rotation]
    call fields%take('tilt', 'rotation', rotation)
    checked%upper%rotation = rotation(1)
    checked%lower%rotation = rotation(2)
    largest = maxval(abs(rotation))
    if (largest > 2 * pi) &
      call checked%notes%add(checked%file // ': note: rotation: ' // real_text(largest) // &
           ' radians are more than a whole turn; as degrees they would be ' // &
           real_text(largest * pi / 180) // ' radians')
  end subroutine read_tilt

end module asperity_scene_reader
