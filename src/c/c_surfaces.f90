!> The library for C: random surfaces, and the report of the original program on a card deck.
module asperity_c_surfaces
  use, intrinsic :: iso_c_binding, only: c_associated, c_f_pointer, c_int, c_ptr
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity, only: add_surface, arithmetic_names, card_deck, decimal_text, generate_surface, &
                      generated_surface, generation_spec, notes_of_deck, original_records, &
                      original_request, plan_surface, read_card_deck, run_in_arithmetic, &
                      surface_plan, text_buffer, thesis_tables, write_report
  use asperity_c_arguments, only: require_text, take_spec, take_word
  use asperity_c_outcome, only: begin_outcome, finish_outcome, outcome, set_text, table_upper, &
                                text_notes, text_of, text_report
  use asperity_library_turn, only: library_turn
  implicit none
  private

  public :: c_generate, c_report

contains

  !> `asperity_generate`.
  type(c_ptr) function c_generate(path, groups, member) bind(c, name='asperity_generate') &
    result(handle)
    type(c_ptr), value :: path        !! specification, where `groups` is null
    type(c_ptr), value :: groups      !! text of a specification; may be null
    integer(c_int), value :: member   !! number in the ensemble, from 1
    type(library_turn) :: turn
    type(outcome), pointer :: new
    type(generation_spec) :: spec
    type(surface_plan) :: plan
    type(generated_surface) :: surface
    real(real64), allocatable :: x(:), y(:), height(:), radius(:)
    integer :: side

    call begin_outcome(new, handle, turn)
    if (.not. associated(new)) return
    call take_spec(path, groups, spec, new%problems)
    if (new%problems%count() == 0 .and. spec%is_map) &
      call new%problems%add(spec%file // ': found a height map, expected surfaces: ' // &
                            'asperity_generate_map makes maps')
    if (new%problems%count() == 0 .and. (member < 1 .or. member > spec%ensemble)) &
      call new%problems%add('surface: found ' // decimal_text(member) // &
                            ', which is not in the ' // &
                            'ensemble of ' // spec%file // ', expected a number from 1 to ' // &
                            decimal_text(spec%ensemble))
    do side = 1, 2
      if (.not. new%is_good()) exit
      call plan_surface(spec, side, plan)
      call generate_surface(plan, member, surface, new%failure)
      if (allocated(new%failure)) exit
      call surface%reals(x, y, height, radius)
      call add_surface(x, y, height, radius, new%tables(table_upper + side - 1), '')
    end do
    call finish_outcome(new)
  end function c_generate

  !> `asperity_make_report`.
  type(c_ptr) function c_report(path, arithmetic, tables, number) &
    bind(c, name='asperity_make_report') result(handle)
    type(c_ptr), value :: path         !! card deck
    type(c_ptr), value :: arithmetic   !! name; null: ibm370
    type(c_ptr), value :: tables       !! positions whose are printed; null: as in the thesis
    integer(c_int), value :: number    !! of them
    type(library_turn) :: turn
    type(outcome), pointer :: new
    type(card_deck) :: deck
    character(len=:), allocatable :: notes
    type(original_request) :: request
    type(original_records) :: records
    type(text_buffer) :: report
    integer(c_int), pointer :: printed(:)
    integer :: i, which

    call begin_outcome(new, handle, turn)
    if (.not. associated(new)) return
    call require_text('deck', path, new%problems)
    if (new%problems%count() == 0) call read_card_deck(text_of(path), deck, new%problems)
    which = 1
    call take_word('arithmetic', arithmetic, arithmetic_names, which, new%problems)
    request%keep_contacts(thesis_tables) = .not. c_associated(tables)
    if (c_associated(tables) .and. number < 0_c_int) then
      call new%problems%add('number: found ' // decimal_text(number) // ', expected 0 or more')
    else if (c_associated(tables)) then
      call c_f_pointer(tables, printed, [number])
      do i = 1, size(printed)
        if (printed(i) < 1 .or. printed(i) > size(request%keep_contacts)) then
          call new%problems%add('tables: found ' // decimal_text(printed(i)) // &
                                ', expected positions from 1 to 100')
        else
          request%keep_contacts(printed(i)) = .true.
        end if
      end do
    end if
    if (new%problems%count() == 0) then
      call run_in_arithmetic(trim(arithmetic_names(which)), deck, request, records, new%failure)
      if (allocated(new%failure)) then
        new%failure = text_of(path) // ': ' // new%failure
      else
        call write_report(records, request%keep_contacts, .false., report)
        call set_text(new, text_report, report%text())
      end if
      call notes_of_deck(text_of(path), deck, notes)
      call set_text(new, text_notes, notes // records%notes%text())
    end if
    call finish_outcome(new)
  end function c_report

end module asperity_c_surfaces
